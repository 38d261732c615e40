"""One `main` for all nodes: start, spin, stop cleanly, and the exit code that says how it went.

A signal interrupts the construction of nodes by an exception, but never a callback: rclpy's own
handler would shut the context down under the executor's threads, and an exception that comes out
of the executor's compiled code may end the process by abort(). The loop looks for it instead.
"""

from __future__ import annotations

import faulthandler
import inspect
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType

import rclpy
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from floornav_common.ros.parameters import ParameterError
from floornav_common.stop_signals import StopSignals

EXIT_OK, EXIT_FAILED, EXIT_USAGE = 0, 1, 2
_ENDING_S = 20.0  # Fast DDS was once seen to wait for itself for ever while a node was destroyed
_SPIN_S = 0.5  # spin() and spin_once(None) of the wheels' EventsExecutor never return
_FOR_ONE_NODE = (
    "; -p NAME:=VALUE goes to every node of the process: write -p NODE:NAME:=VALUE for one of them,"
    " or, in a namespace, a --params-file with /**/NODE"
)
_BAD_START = ("RCLError", "RCLInvalidROSArgsError", "UnknownROSArgsError", "InvalidNodeNameError")


def run_node(make_node: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Run one node until it is told to stop.

    Args:
        make_node: The node's class.
        args: Command line; None for `sys.argv`.

    Returns:
        Exit code: 0 stopped by SIGINT, SIGTERM or shutdown, however early, 1 failed, 2 not usable
        as given.
    """
    try:
        with _bad_start_as_usage():
            others = remove_ros_args(sys.argv)[1:] if args is None else []
    except ParameterError as error:
        print(error, file=sys.stderr)
        return EXIT_USAGE
    if {"-h", "--help"} & set(others):
        print(_usage(make_node))
        return EXIT_OK
    if others:
        print(
            f"{' '.join(others)}: not understood; put --ros-args before -p and -r", file=sys.stderr
        )
        return EXIT_USAGE
    return run_nodes([make_node], args)


def _usage(make_node: Callable[[], Node]) -> str:
    """Return the text of `--help`: what the node's module says of it, and how to set parameters."""
    text = (inspect.getdoc(inspect.getmodule(make_node)) or "").strip()
    return (
        f"{text}\n\nusage: --ros-args [-p NAME:=VALUE ...] [-r FROM:=TO ...] [--params-file YAML]"
    )


def run_nodes(make_nodes: Sequence[Callable[[], Node]], args: Sequence[str] | None = None) -> int:
    """Run several nodes in one process until they are told to stop; see `run_node`."""
    nodes: list[Node] = []
    has_begun = False
    signals = StopSignals()
    try:
        with _bad_start_as_usage(), signals.raised():
            options = SignalHandlerOptions.NO
            rclpy.init(args=None if args is None else list(args), signal_handler_options=options)
            has_begun = True
            for make_node in make_nodes:
                nodes.append(make_node())
        _spin(nodes, signals)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except Exception as error:
        if has_begun and (signals.have_come or not rclpy.ok()):
            return EXIT_OK  # only cut short by the signal or the shutdown
        if isinstance(error, ParameterError):
            is_for_one = len(make_nodes) > 1 and "unknown parameter" in str(error)
            print(f"{error}{_FOR_ONE_NODE if is_for_one else ''}", file=sys.stderr)
            return EXIT_USAGE
        traceback.print_exc()
        return EXIT_FAILED
    finally:
        _leave(nodes)
    return EXIT_OK


def _leave(nodes: Sequence[Node]) -> None:
    """Destroy nodes and leave the graph; a process that hangs there says where, and exits with 1.

    The watch needs no lock of the interpreter, which the code that hangs may hold.
    """
    faulthandler.dump_traceback_later(_ENDING_S, exit=True, file=sys.__stderr__)
    try:
        for node in nodes:
            node.destroy_node()
        rclpy.try_shutdown()
    finally:
        faulthandler.cancel_dump_traceback_later()


def node_classes(module: ModuleType) -> list[type[Node]]:
    """Return the nodes that a module itself defines."""
    own = [c for c in vars(module).values() if inspect.isclass(c)]
    return [c for c in own if c.__module__ == module.__name__ and issubclass(c, Node)]


def make_executor() -> Executor:
    """Return the cheapest executor there is: EventsExecutor where rclpy has it."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor()
    return EventsExecutor()


@contextmanager
def _bad_start_as_usage() -> Iterator[None]:
    """Turn what rcl says of arguments and names that cannot be into a ParameterError."""
    try:
        yield
    except Exception as error:
        if type(error).__name__ not in _BAD_START:
            raise
        raise ParameterError(_one_line(error)) from error


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split()).split(", at /")[0].removesuffix(" Error: error not set")
    if type(error).__name__ == "UnknownROSArgsError":
        return f"unknown ROS argument {text}: put -p before each NAME:=VALUE, -r before FROM:=TO"
    return text


def _spin(nodes: Sequence[Node], signals: StopSignals) -> None:
    executor = make_executor()
    try:
        for node in nodes:
            executor.add_node(node)
        while rclpy.ok() and not signals.have_come:
            executor.spin_once(timeout_sec=_SPIN_S)
    finally:
        executor.shutdown()  # its threads end while what they use is still there
