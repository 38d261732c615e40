"""ROS parameters from configuration dataclasses: declared, validated and changed in one place."""

from __future__ import annotations

import typing
from collections.abc import Callable
from typing import Any, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from floornav_common import config_files
from floornav_common.config import range_text

C = TypeVar("C")


class ParameterError(ValueError):
    """The parameters that a node was started with are not usable; one line says why."""


def declare_config(
    node: Node,
    config_class: type[C],
    prefix: str = "",
    on_change: Callable[[C], None] | None = None,
) -> C:
    """Declare a parameter for each field of a configuration and return it filled.

    Args:
        node: Node to declare them on.
        config_class: Frozen dataclass made with `floornav_common.config.param`.
        prefix: Group of the names, without the dot.
        on_change: Called with the new configuration after a set at run time was accepted.

    Raises:
        ParameterError: If a value given at the start is of the wrong type or out of range.
    """
    names = config_files.parameter_names(config_class, prefix)
    overrides = _overrides(node)
    given = {f: overrides[n].value for n, f in names.items() if n in overrides}
    try:
        config = config_files.config_from_mapping(config_class, given, prefix)
    except ValueError as error:
        raise ParameterError(f"{node.get_fully_qualified_name()}: parameter {error}") from error
    values = config_files.flat_values(config)
    for name, (field, hint) in config_files.parameter_fields(config_class, prefix).items():
        value = values[names[name]]
        descriptor = _descriptor(field, hint)
        node.declare_parameter(
            name, list(value) if isinstance(value, tuple) else value, descriptor, True
        )
    _watch(node, config, names, prefix, on_change)
    return config


def refuse_unknown_parameters(node: Node) -> None:
    """Refuse parameters given at the start that nothing declared; call it after all declarations.

    Raises:
        ParameterError: Naming them, and the nearest names that exist.
    """
    declared = node.get_parameters_by_prefix("")
    try:
        config_files.refuse_unknown(_overrides(node), declared, node.get_fully_qualified_name())
    except ValueError as error:
        raise ParameterError(str(error)) from error


def _overrides(node: Node) -> dict[str, Parameter]:
    # rclpy has no public way to read what was given but never declared.
    return dict(node._parameter_overrides)


def _descriptor(field: Any, hint: Any) -> ParameterDescriptor:
    m = field.metadata
    descriptor = ParameterDescriptor(
        description=config_files.describe(field),
        additional_constraints=range_text(field),
        read_only=bool(m.get("read_only")),
        # rclpy takes an empty list for one of bytes, and would then refuse all others.
        dynamic_typing=typing.get_origin(hint) is tuple,
    )
    if m.get("ge") is not None and m.get("le") is not None:
        if hint is float:
            limits = FloatingPointRange(from_value=float(m["ge"]), to_value=float(m["le"]))
            descriptor.floating_point_range = [limits]
        elif hint is int:
            limits = IntegerRange(from_value=int(m["ge"]), to_value=int(m["le"]))
            descriptor.integer_range = [limits]
    return descriptor


def _watch(
    node: Node, config: C, names: dict[str, str], prefix: str, on_change: Callable[[C], None] | None
) -> None:
    current = config

    def changed(parameters: list[Parameter]) -> C:
        values = {names[p.name]: p.value for p in parameters if p.name in names}
        kept = config_files.flat_values(current)
        return config_files.config_from_mapping(type(current), {**kept, **values}, prefix)

    def check(parameters: list[Parameter]) -> SetParametersResult:
        try:
            changed(parameters)
            return SetParametersResult(successful=True)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))

    def apply(parameters: list[Parameter]) -> None:
        nonlocal current
        if any(p.name in names for p in parameters):
            current = changed(parameters)
            if on_change is not None:
                on_change(current)

    _take_integers_for_floats(node)
    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(apply)


def _take_integers_for_floats(node: Node) -> None:
    """Let `ros2 param set NODE gain 1` do for 1.0; rclpy would refuse the type.

    Once a node: of several pre-set callbacks rclpy strings the answers together.
    """

    def as_declared(parameter: Parameter) -> Parameter:
        is_integer = parameter.type_ == Parameter.Type.INTEGER
        if not is_integer or not node.has_parameter(parameter.name):
            return parameter
        if node.describe_parameter(parameter.name).type != Parameter.Type.DOUBLE.value:
            return parameter
        return Parameter(parameter.name, Parameter.Type.DOUBLE, float(parameter.value))

    if not node._pre_set_parameters_callbacks:
        node.add_pre_set_parameters_callback(
            lambda parameters: [as_declared(p) for p in parameters]
        )
