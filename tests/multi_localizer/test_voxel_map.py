import numpy as np
import pytest

from multi_localizer.voxel_map import VoxelMap, load_voxel_map, save_voxel_map


def small_map(shape=(2, 3, 4), **places):
    rng = np.random.default_rng(0)
    occupied = rng.random(shape) < 0.5
    color = rng.integers(0, 256, (*shape, 3), dtype=np.uint8)
    color[~occupied] = 0
    return VoxelMap(color, occupied, 0.01, 0.32, **places)


def test_a_map_comes_back_from_its_file_as_it_was(tmp_path):
    voxels = small_map(origin_x_m=-1.5, origin_y_m=2.25, origin_z_m=-0.32, frame="room")
    path = save_voxel_map(tmp_path / "room.npz", voxels)
    back = load_voxel_map(path)
    assert np.array_equal(back.color, voxels.color)
    assert np.array_equal(back.occupied, voxels.occupied)
    assert (back.cell_m, back.layer_m, back.frame) == (0.01, 0.32, "room")
    assert (back.origin_x_m, back.origin_y_m, back.origin_z_m) == (-1.5, 2.25, -0.32)
    assert [p.name for p in tmp_path.iterdir()] == ["room.npz"]


def test_size_and_diagonal_by_hand():
    voxels = small_map((8, 300, 400))
    assert voxels.size_m == pytest.approx((4.0, 3.0, 2.56))
    assert voxels.farthest_m == pytest.approx(5.0)


def test_the_color_of_nothing_is_not_kept(tmp_path):
    color = np.full((1, 1, 2, 3), 7, dtype=np.uint8)
    voxels = VoxelMap(color, np.array([[[True, False]]]), 0.1, 0.1)
    back = load_voxel_map(save_voxel_map(tmp_path / "m.npz", voxels))
    assert back.color.tolist() == [[[[7, 7, 7], [0, 0, 0]]]]


def test_a_file_is_replaced_only_on_demand(tmp_path):
    path = save_voxel_map(tmp_path / "m.npz", small_map())
    with pytest.raises(FileExistsError, match="another name"):
        save_voxel_map(path, small_map())
    save_voxel_map(path, small_map((1, 1, 1)), overwrite=True)
    assert load_voxel_map(path).shape == (1, 1, 1)


def test_what_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(FileNotFoundError, match="no folder"):
        save_voxel_map(tmp_path / "none" / "m.npz", small_map())
    target = tmp_path / "folder.npz"
    (target / "inside").mkdir(parents=True)
    with pytest.raises(OSError):
        save_voxel_map(target, small_map(), overwrite=True)
    assert [p.name for p in tmp_path.iterdir()] == ["folder.npz"]


@pytest.mark.parametrize("kept", [0, 4, 100, 600, -30, -1])
def test_a_file_cut_off_anywhere_is_refused(tmp_path, kept):
    path = save_voxel_map(tmp_path / "m.npz", small_map((4, 16, 16)))
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(ValueError, match="m.npz is no voxel map, or is damaged"):
        load_voxel_map(path)


def test_a_damaged_byte_is_noticed(tmp_path):
    path = save_voxel_map(tmp_path / "m.npz", small_map((4, 32, 32)))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"m\.npz"):
        load_voxel_map(path)


def test_one_wrong_bit_anywhere_is_a_value_error_or_harmless(tmp_path):
    path = save_voxel_map(tmp_path / "m.npz", small_map((2, 8, 8)))
    good, rng = path.read_bytes(), np.random.default_rng(0)
    num_refused = 0
    for place in rng.integers(0, len(good), 600).tolist():
        data = bytearray(good)
        data[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(data)
        try:
            load_voxel_map(path)
        except ValueError:
            num_refused += 1
    assert num_refused > 300


def test_files_with_pickles_are_refused_without_advice_to_load_them(tmp_path):
    np.savez(tmp_path / "m.npz", format=np.array([object()]))
    (tmp_path / "map.yaml").write_text("image: map.pgm\n")
    for name in ("m.npz", "map.yaml"):
        with pytest.raises(ValueError, match="is no voxel map") as refusal:
            load_voxel_map(tmp_path / name)
        assert "unsafe" not in str(refusal.value) and "object" not in str(refusal.value)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="no voxel map"):
        load_voxel_map(tmp_path / "m.npz")
    np.save(tmp_path / "m.npy", np.zeros(3))
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    (tmp_path / "text.npz").write_text("voxels: none\n")
    for name in ("m.npy", "other.npz", "text.npz"):
        with pytest.raises(ValueError, match="is no voxel map"):
            load_voxel_map(tmp_path / name)


def test_a_map_that_lacks_a_part_is_refused(tmp_path):
    path = save_voxel_map(tmp_path / "m.npz", small_map())
    parts = dict(np.load(path))
    np.savez(path, **{**parts, "version": 2})
    with pytest.raises(ValueError, match="of version 2"):
        load_voxel_map(path)
    for name in ("color", "occupied", "cell_m", "layer_m", "origin_m", "frame", "version"):
        np.savez(path, **{k: v for k, v in parts.items() if k != name})
        with pytest.raises(ValueError, match=f"damaged voxel map: it lacks {name}"):
            load_voxel_map(path)
    np.savez(path, **{**parts, "origin_m": [0.0, 0.0]})
    with pytest.raises(ValueError, match="damaged voxel map"):
        load_voxel_map(path)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"color": np.zeros((2, 3, 4), np.uint8)}, "color must be"),
        ({"color": np.zeros((2, 3, 4, 3))}, "uint8"),
        ({"occupied": np.zeros((2, 3, 4))}, "bool"),
        ({"occupied": np.zeros((2, 0, 4), bool)}, "occupied must be"),
        ({"occupied": np.zeros((3, 4), bool)}, "occupied must be"),
        ({"cell_m": 0.0}, "cell_m must be above 0"),
        ({"layer_m": -1.0}, "layer_m must be above 0"),
        ({"origin_z_m": np.nan}, "origin_z_m must be finite"),
    ],
)
def test_parts_that_do_not_fit_are_refused(change, text):
    good = {
        "color": np.zeros((2, 3, 4, 3), np.uint8), "occupied": np.zeros((2, 3, 4), bool),
        "cell_m": 0.01, "layer_m": 0.16,
    }  # fmt: skip
    with pytest.raises(ValueError, match=text):
        VoxelMap(**{**good, **change})
