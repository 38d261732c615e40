"""Samples of one's own transform told from another's."""

from __future__ import annotations

from floornav_common.transform_owner import SentTransforms


def test_what_comes_back_is_ours_and_anything_else_is_not() -> None:
    sent = SentTransforms("map", "odom")
    sent.note(5, (1.0, 0.0, 0.0))
    assert not sent.is_foreign("odom", 5, (1.0, 0.0, 0.0))
    assert sent.is_foreign("odom", 6, (1.0, 0.0, 0.0))
    assert sent.is_foreign("odom", 5, (1.5, 0.0, 0.0))


def test_other_children_are_nobodys_business() -> None:
    assert not SentTransforms("map", "odom").is_foreign("base_link", 5, (0.0, 0.0, 0.0))


def test_what_is_remembered_is_bounded() -> None:
    sent = SentTransforms("map", "odom")
    for stamp in range(1000):
        sent.note(stamp, (0.0, 0.0, 0.0))
    assert len(sent._sent) == 400
    assert not sent.is_foreign("odom", 999, (0.0, 0.0, 0.0))
