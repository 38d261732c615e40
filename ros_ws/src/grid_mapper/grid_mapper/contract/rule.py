"""A rule of a consumer, a topic as it was heard, and what came of judging one by the other."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

PASSED, FAILED, OPEN = "pass", "FAIL", "not judged"


@dataclass(frozen=True)
class Rule:
    """What a consumer wants.

    Attributes:
        name: Short, unique.
        wants: What must be so.
        who: Who wants it.
        source: Where that is written.
    """

    name: str
    wants: str
    who: str
    source: str


@dataclass
class Topic:
    """What was heard on a topic.

    Attributes:
        name: Full name.
        msgtype: Such as `sensor_msgs/msg/LaserScan`.
        qos: Profiles its publishers offer, as rosbags' `Qos`; empty where not known.
        messages: In the order of arrival.
        arrived_ns: When each arrived or was recorded.
    """

    name: str
    msgtype: str
    qos: list[Any] = field(default_factory=list)
    messages: list[Any] = field(default_factory=list)
    arrived_ns: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Verdict:
    """What came of one rule on one topic.

    Attributes:
        topic: Its name.
        rule: The rule.
        result: `PASSED`, `FAILED` or `OPEN`.
        text: What is wrong, and how often; or why it was not judged.
    """

    topic: str
    rule: Rule
    result: str
    text: str = ""


def judge_each(topic: Topic, rule: Rule, check: Callable[[Any], str]) -> Verdict:
    """Return the verdict on a rule that each message is held to; `check` says what is wrong."""
    return of_problems(topic, rule, [check(message) for message in topic.messages])


def of_problems(topic: Topic, rule: Rule, problems: Iterable[str]) -> Verdict:
    """Return the verdict on a list of problems, "" where there is none."""
    all_of = list(problems)
    if not all_of:
        return Verdict(topic.name, rule, OPEN, "no message to judge")
    found = [problem for problem in all_of if problem]
    if not found:
        return Verdict(topic.name, rule, PASSED)
    return Verdict(topic.name, rule, FAILED, f"{len(found)} of {len(all_of)}: {found[0]}")
