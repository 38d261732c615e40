"""Image and CompressedImage <-> numpy, for the 8-bit encodings that cameras of ours send."""

from __future__ import annotations

from typing import Any

import numpy as np

from floornav_common.ros.arrays import from_field, to_field

CHANNELS = {"mono8": 1, "bgr8": 3, "rgb8": 3, "bgra8": 4}


def image_to_array(msg: Any, encoding: str = "") -> np.ndarray:
    """Return the pixels of an Image.

    Args:
        msg: sensor_msgs/Image, or one read by rosbags. Rows may be padded (`step`).
        encoding: Encoding wanted; "" for the message's own.

    Returns:
        Shape (H, W) for mono8, else (H, W, channels), uint8. A read-only view on the message
        unless the encoding had to be changed.

    Raises:
        ValueError: If the encoding is none of ours, the data are big-endian, or sizes disagree.
    """
    if msg.encoding not in CHANNELS:
        raise ValueError(f"image encoding must be {_names()}, got '{msg.encoding}'")
    if msg.is_bigendian:
        raise ValueError(f"image data must be little-endian, got big-endian '{msg.encoding}'")
    num_channels = CHANNELS[msg.encoding]
    height, width, step = int(msg.height), int(msg.width), int(msg.step)
    if height == 0 or width == 0:
        raise ValueError(f"image must not be empty, got {width} x {height}")
    if step < width * num_channels:
        raise ValueError(f"image step must be >= {width * num_channels} bytes, got {step}")
    data = from_field(msg.data, np.uint8)
    if len(data) != step * height:
        raise ValueError(f"image data must be {step * height} bytes, got {len(data)}")
    shape = (height, width) if num_channels == 1 else (height, width, num_channels)
    strides = (step, 1) if num_channels == 1 else (step, num_channels, 1)
    pixels: np.ndarray = np.ndarray(shape, np.uint8, buffer=data, strides=strides)
    return _recolor(pixels, msg.encoding, encoding or msg.encoding)


def array_to_image(pixels: np.ndarray, encoding: str, stamp: Any, frame_id: str) -> Any:
    """Return pixels as a sensor_msgs/Image.

    Args:
        pixels: Shape (H, W) for mono8, else (H, W, channels), uint8.
        encoding: One of `CHANNELS`.
        stamp: builtin_interfaces/Time of the exposure.
        frame_id: Optical frame of the camera.

    Raises:
        ValueError: If shape or dtype do not fit the encoding.
    """
    from sensor_msgs.msg import Image

    _check_pixels(pixels, encoding)
    msg = Image(encoding=encoding, is_bigendian=0, check_fields=True)  # then data is not copied
    msg.height, msg.width = pixels.shape[:2]
    msg.step = pixels.shape[1] * CHANNELS[encoding]
    msg.data = to_field(pixels)
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    return msg


def compressed_to_array(msg: Any, encoding: str = "bgr8") -> np.ndarray:
    """Return the pixels of a CompressedImage (jpeg or png).

    Raises:
        ValueError: If the data are not a picture or the encoding is none of ours.
    """
    import cv2

    if encoding not in CHANNELS:
        raise ValueError(f"image encoding must be {_names()}, got '{encoding}'")
    if "compressedDepth" in msg.format:
        raise ValueError(f"image format must be jpeg or png, got '{msg.format}'")
    data = from_field(msg.data, np.uint8)
    if not len(data):
        raise ValueError(f"image data must not be empty (format '{msg.format}')")
    pixels = cv2.imdecode(data, cv2.IMREAD_COLOR)
    if pixels is None:
        raise ValueError(f"image data cannot be decoded (format '{msg.format}', {len(data)} bytes)")
    return _recolor(pixels, "bgr8", encoding)


def array_to_compressed(
    pixels: np.ndarray, encoding: str, stamp: Any, frame_id: str, *, quality: int | None = 90
) -> Any:
    """Return pixels as a sensor_msgs/CompressedImage: jpeg of a quality, png if that is None."""
    import cv2
    from sensor_msgs.msg import CompressedImage

    _check_pixels(pixels, encoding)
    kind = "png" if quality is None else "jpeg"
    options = [] if quality is None else [cv2.IMWRITE_JPEG_QUALITY, quality]
    plain = pixels if encoding == "mono8" else _recolor(pixels, encoding, "bgr8")
    is_done, data = cv2.imencode(f".{kind}", plain, options)
    if not is_done:
        raise ValueError(f"image of shape {pixels.shape} cannot be written as {kind}")
    msg = CompressedImage(format=f"{encoding}; {kind} compressed bgr8")
    msg.data = to_field(data)
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    return msg


def _recolor(pixels: np.ndarray, have: str, want: str) -> np.ndarray:
    if have == want:
        return pixels
    if want not in CHANNELS:
        raise ValueError(f"image encoding must be {_names()}, got '{want}'")
    import cv2

    names = {"mono8": "GRAY", "bgr8": "BGR", "rgb8": "RGB", "bgra8": "BGRA"}
    code = getattr(cv2, f"COLOR_{names[have]}2{names[want]}")
    changed: np.ndarray = cv2.cvtColor(np.ascontiguousarray(pixels), code)
    return changed


def _check_pixels(pixels: np.ndarray, encoding: str) -> None:
    if encoding not in CHANNELS:
        raise ValueError(f"image encoding must be {_names()}, got '{encoding}'")
    num_channels = CHANNELS[encoding]
    is_fit = pixels.ndim == 2 if num_channels == 1 else pixels.shape[2:] == (num_channels,)
    if not is_fit or pixels.dtype != np.uint8 or not pixels.size:
        raise ValueError(f"pixels must be {encoding} uint8, got {pixels.shape} {pixels.dtype}")


def _names() -> str:
    return "one of " + ", ".join(CHANNELS)
