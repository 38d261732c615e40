"""From masks of the floor, goals and motion to the robot's pose: fit, then settle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from floornav_common.floor_camera import FloorCamera
from floornav_common.image_size import camera_at_size, shape_doubt
from floornav_common.se2 import SE2
from multi_localizer.floor_config import FloorFitConfig
from multi_localizer.floor_fitter import FloorFit, FloorShapeFitter
from multi_localizer.floor_misfit import FloorMisfit
from multi_localizer.floor_node_config import FloorPoseConfig
from multi_localizer.floor_plan import FloorPlan
from multi_localizer.floor_tracker import FloorTracker
from multi_localizer.pose_estimate import PoseEstimate, moved


class Fitter(Protocol):
    """What fits masks of one size."""

    def fit(self, mask: np.ndarray, guess: PoseEstimate | None = None) -> FloorFit:
        """Return the poses that a mask fits."""
        ...


MakeFitter = Callable[[FloorCamera, FloorPlan, FloorFitConfig], Fitter]


class FloorLocalizer:
    """Keeps the robot's pose on a floor of known shape.

    Args:
        camera: The camera that the masks come from; masks of another size are taken as those of
            its resized images.
        plan: The floor.
        config: Fit and belief.
        make_fitter: Makes what fits masks of one camera.

    Attributes:
        tracker: Which of the poses that fit is the robot's.
        misfit: Whether plan and camera are in doubt.
        newest: What the newest mask fits; None before the first.
        size_doubt: What is doubtful about the size of the masks; "" if nothing.
    """

    def __init__(
        self,
        camera: FloorCamera,
        plan: FloorPlan,
        config: FloorPoseConfig,
        make_fitter: MakeFitter = FloorShapeFitter,
    ) -> None:
        # Where the camera is on the robot comes with each mask.
        self._calibrated = replace(camera, position_m=(0.0, 0.0))
        self._plan, self._config, self._make_fitter = plan, config, make_fitter
        self._fitters: dict[tuple[int, ...], Fitter] = {}
        self.tracker = FloorTracker(plan.goals, config.track)
        self.misfit = FloorMisfit()
        self.newest: FloorFit | None = None
        self.size_doubt = ""

    def reconfigure(self, config: FloorPoseConfig) -> None:
        """Go on with other values."""
        self._config, self.tracker.config = config, config.track
        self._fitters.clear()

    def take_mask(
        self, stamp_ns: int, mask: np.ndarray, T_base_floor: SE2, T_odom_base: SE2 | None
    ) -> None:
        """Fit a mask and follow the robot with what comes out.

        Args:
            stamp_ns: Its stamp.
            mask: Not 0 where the floor is, (H, W), uint8.
            T_base_floor: Where the floor below the camera is on the robot.
            T_odom_base: Where odometry has the robot then; None without odometry.

        Raises:
            ValueError: The mask is of another shape than the camera's images.
        """
        fitter = self._fitter(mask.shape)
        guess = self._guess(stamp_ns, T_odom_base)
        fit = fitter.fit(mask, None if guess is None else moved(guess, T_base_floor))
        self.newest = fit
        self.misfit.note(stamp_ns, fit)
        T_floor_base = T_base_floor.inverse()
        candidates = [moved(c, T_floor_base) for c in fit.candidates]
        self.tracker.update(
            stamp_ns, candidates, fit.problem, T_odom_base, fit.costs, fit.first_cost
        )

    def warm_up(self) -> None:
        """Compile what is compiled, on a mask of the camera's size; nothing is kept of it."""
        camera = self._calibrated
        mask = camera.floor_mask(0.3 * self._plan.reach).astype(np.uint8)
        fitter = self._fitter(mask.shape)
        fitter.fit(mask, None)
        mask.flags.writeable = False  # as those of messages are: other code is compiled for them
        fitter.fit(mask, PoseEstimate(SE2.identity(), np.eye(3)))

    def _guess(self, stamp_ns: int, T_odom_base: SE2 | None) -> PoseEstimate | None:
        """Return where the fit may begin; None as long as all that fits is to be looked for."""
        tracker = self.tracker
        has_rivals = len(tracker.hypotheses) > len(self._plan.symmetries)
        if has_rivals or not tracker.has_agreed:
            return None
        return tracker.guess(stamp_ns, T_odom_base)

    def _fitter(self, shape: tuple[int, ...]) -> Fitter:
        if shape not in self._fitters:
            try:
                camera = camera_at_size(self._calibrated, *shape)
            except ValueError as error:
                cure = "give `camera_model` of the camera that the masks come from"
                raise ValueError(f"{error}: {cure}") from error
            self.size_doubt = shape_doubt(self._calibrated, *shape)
            self._fitters = {shape: self._make_fitter(camera, self._plan, self._config.fit)}
        return self._fitters[shape]
