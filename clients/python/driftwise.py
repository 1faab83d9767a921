"""Driftwise for controllers in Python: compensated motor coordinates from a running daemon.

    import driftwise
    with driftwise.Cell("192.168.7.1:50443", ca="authority.pem", token_file="stage.token") as cell:
        target = cell.target(x_mm=1.5, force_N=0)
        print(target.q_mm["q1_mm"], target.flags)
        follower = cell.follow(x_mm=1.5)      # newest target of one pose, kept by a thread of its own
        print(follower.latest())              # from memory: never waits for the network

One file; copy it. Needs Python 3.9, grpcio and protobuf (Debian: python3-grpcio python3-protobuf).
Asking never moves anything; stop_all() halts. Failures are DriftwiseError with the daemon's own words and stable reason
(docs/api.md); this file adds NO_DAEMON, TIMEOUT, NO_TOKEN, BAD_CREDENTIALS, NOT_YET and EXPIRED. All of it may be used from several threads at once.

On a command line: driftwise.py [--ca FILE] [--token-file FILE] [--cert FILE --key FILE] HOST:PORT x_mm=1.5 [force_N=0]
prints one JSON object; exit code 0, 2 usage, 4 daemon not reached, 5 refused.
"""
from __future__ import annotations

import argparse
import atexit
import dataclasses
import datetime
import json
import random
import sys
import threading
import time
import traceback
from typing import Callable, Dict, Iterator, List, Optional, Tuple

import grpc
from google.protobuf import any_pb2, descriptor_pb2, descriptor_pool, duration_pb2, timestamp_pb2  # noqa: F401

try:
    from google.protobuf.message_factory import GetMessageClass as _message_class  # protobuf 4.22 and later
except ImportError:
    from google.protobuf.message_factory import MessageFactory as _MessageFactory
    _message_class = None

__all__ = ["Cell", "DriftwiseError", "Follower", "Identity", "MotorCoordinate", "Stopped", "Target"]


# The messages that are needed here, with the numbers of proto/driftwise/v1; what else an answer holds is passed over.
# A field: name, number, type; "*" before the type: repeated; "?": optional. Other types are messages.
_MESSAGES: Dict[str, List[Tuple[str, int, str]]] = {
    "ChannelValue": [("channel", 1, "string"), ("value", 2, "?double")],
    "ComputeTargetRequest": [("pose", 1, "*ChannelValue")],
    "ComputeTargetResponse": [("target", 1, "Target")],
    "WatchTargetsRequest": [("pose", 1, "*ChannelValue"), ("min_interval_duration", 2, "google.protobuf.Duration")],
    "WatchTargetsResponse": [("target", 1, "Target")],
    "MotorCoordinate": [("channel", 1, "string"), ("position_mm", 2, "double"), ("u_nm", 3, "double"),
                        ("u90_nm", 4, "double"), ("expanded_nm", 6, "double")],
    "Target": [("coordinates", 1, "*MotorCoordinate"), ("model_id", 2, "int64"),
               ("conditions_time", 3, "google.protobuf.Timestamp"), ("valid_until_time", 4, "google.protobuf.Timestamp"),
               ("flags", 5, "*int32"), ("outside_channels", 6, "*string"), ("stale_channels", 7, "*string"),
               ("missing_channels", 8, "*string"), ("unreachable_channels", 9, "*string"),
               ("unlimited_channels", 10, "*string"), ("ignored_channels", 11, "*string"),
               ("zero_outside_channels", 12, "*string")],
    "StopAllRequest": [],
    "StopAllResponse": [("confirmed", 1, "bool"), ("message", 2, "string")],
    "GetIdentityRequest": [],
    "GetIdentityResponse": [("identity", 1, "Identity")],
    "Identity": [("name", 1, "string"), ("role", 2, "int32"), ("proof", 3, "string"), ("from", 5, "string")],
    "ErrorDetail": [("reason", 1, "string"), ("message", 2, "string")],
    "ErrorStatus": [("code", 1, "int32"), ("message", 2, "string"), ("details", 3, "*google.protobuf.Any")],
}
# Of Target.Flag and the list of channels that each speaks of, as on the text line (docs/target-line.md).
_FLAGS = {1: ("OUTSIDE_DOMAIN", "outside_channels"), 2: ("STALE_TEMPERATURE", "stale_channels"),
          3: ("MISSING_TEMPERATURE", "missing_channels"), 4: ("EXPIRED_CONDITIONS", None),
          5: ("UNANCHORED_DATUM", None), 6: ("OUTSIDE_LIMITS", "unreachable_channels"),
          7: ("UNKNOWN_LIMITS", "unlimited_channels"), 8: ("IGNORED_COORDINATE", "ignored_channels"),
          9: ("CONFIGURATION_CHANGED", None), 10: ("UNJUDGED_MODEL", None),
          11: ("ZERO_OUTSIDE_DOMAIN", "zero_outside_channels"),
          12: ("DOUBTFUL_MODEL", None)}
_WITHOUT_UNIT = ("unreachable_channels", "unlimited_channels")  # "q3_mm" is q3 in a flag
_ROLES = {1: "viewer", 2: "controller", 3: "operator", 4: "engineer", 5: "admin"}
_PACKAGE = "driftwise.client.v1"  # another name than the daemon's: generated classes may be loaded beside these


def _build_messages() -> Dict[str, type]:
    field_type = descriptor_pb2.FieldDescriptorProto
    scalar = {"string": field_type.TYPE_STRING, "double": field_type.TYPE_DOUBLE, "int64": field_type.TYPE_INT64,
              "int32": field_type.TYPE_INT32, "bool": field_type.TYPE_BOOL}
    file = descriptor_pb2.FileDescriptorProto(name="driftwise_client_v1.proto", package=_PACKAGE, syntax="proto3")
    file.dependency.extend(["google/protobuf/any.proto", "google/protobuf/duration.proto", "google/protobuf/timestamp.proto"])
    for name, fields in _MESSAGES.items():
        message = file.message_type.add(name=name)
        for field_name, number, kind in fields:
            field = message.field.add(name=field_name, number=number, label=field_type.LABEL_OPTIONAL)
            if kind[0] == "*":
                field.label = field_type.LABEL_REPEATED
            if kind[0] == "?":
                field.proto3_optional = True
                field.oneof_index = len(message.oneof_decl)
                message.oneof_decl.add(name="_" + field_name)
            kind = kind.lstrip("*?")
            if kind in scalar:
                field.type = scalar[kind]
            else:
                field.type = field_type.TYPE_MESSAGE
                field.type_name = "." + (kind if "." in kind else f"{_PACKAGE}.{kind}")
    pool = descriptor_pool.Default()
    pool.Add(file) if hasattr(pool, "Add") else pool.AddSerializedFile(file.SerializeToString())
    factory = _message_class or _MessageFactory(pool).GetPrototype
    return {name: factory(pool.FindMessageTypeByName(f"{_PACKAGE}.{name}")) for name in _MESSAGES}


_CLASS = _build_messages()


class DriftwiseError(Exception):
    """reason: UPPER_SNAKE and stable, "NO_MODEL"; code: gRPC's, "FAILED_PRECONDITION"; str(): the daemon's sentence."""

    def __init__(self, reason: str, message: str, code: str = "") -> None:
        super().__init__(message)
        self.reason = reason
        self.code = code


@dataclasses.dataclass(frozen=True)
class MotorCoordinate:
    channel: str  # "q1_mm"
    position_mm: float  # move there, as read back from the scale
    u90_nm: float  # 1.645 x standard uncertainty
    expanded_nm: float  # k = 2


@dataclasses.dataclass(frozen=True)
class Target:
    coordinates: Tuple[MotorCoordinate, ...]  # in order of the axes
    model_id: int
    conditions_time: datetime.datetime  # UTC, of the cell
    valid_until: datetime.datetime  # ask again after this
    flags: Tuple[str, ...]  # "OUTSIDE_DOMAIN(x_mm+t07_degC)": what to know before moving there; empty: nothing

    @property
    def q_mm(self) -> Dict[str, float]:
        return {one.channel: one.position_mm for one in self.coordinates}

    @property
    def plain(self) -> bool:
        return not self.flags


@dataclasses.dataclass(frozen=True)
class Stopped:
    confirmed: bool  # every controller has reported no motion; False: use the emergency switch
    message: str


@dataclasses.dataclass(frozen=True)
class Identity:
    name: str
    role: str  # "viewer", "controller", "operator", "engineer", "admin"
    proof: str  # "token", "certificate", ...


def _utc(stamp) -> datetime.datetime:
    epoch = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
    return epoch + datetime.timedelta(seconds=stamp.seconds, microseconds=stamp.nanos // 1000)


def _target_from(message) -> Target:
    flags = []
    for number in message.flags:
        name, channels = _FLAGS.get(number, (f"UNKNOWN_FLAG({number})", None))
        names = list(getattr(message, channels)) if channels else []
        if channels in _WITHOUT_UNIT:
            names = [one.rpartition("_")[0] for one in names]
        named = "+".join(names)
        flags.append(f"{name}({named})" if named else name)
    coordinates = tuple(MotorCoordinate(c.channel, c.position_mm, c.u90_nm, c.expanded_nm) for c in message.coordinates)
    return Target(coordinates, message.model_id, _utc(message.conditions_time), _utc(message.valid_until_time), tuple(flags))


def _error_of(failed: grpc.RpcError, address: str) -> DriftwiseError:
    code = failed.code()
    for key, value in failed.trailing_metadata() or ():
        if key != "grpc-status-details-bin":
            continue
        status = _CLASS["ErrorStatus"].FromString(value)
        for one in status.details:
            detail = _CLASS["ErrorDetail"].FromString(one.value)
            if detail.reason:
                return DriftwiseError(detail.reason, detail.message, code.name)
    if code == grpc.StatusCode.DEADLINE_EXCEEDED:
        return DriftwiseError("TIMEOUT", f"no answer from {address} in time", code.name)
    # A daemon gives its reason. Without one gRPC speaks for it: it is away, or it ends and cancels what is under way.
    return DriftwiseError("NO_DAEMON", f"cannot reach the daemon at {address}: is driftwised running there, and does it "
                          f"show a certificate of this authority? ({code.name}: {failed.details()})", code.name)


def _token_in(text: str, where: str) -> str:
    """Without the line's end of its file. gRPC refuses a header that holds anything else than printable ASCII."""
    token = text.strip()
    if not all("!" <= one <= "~" for one in token):
        raise ValueError(f"{where}: blanks inside or characters that are no printable ASCII, expected one word as "
                         "`driftwise token create` made it")
    return token


def _read(path: Optional[str]) -> Optional[bytes]:
    if path is None:
        return None
    with open(path, "rb") as file:
        return file.read()


class Cell:
    """One daemon. Connects when first asked, and again within about 2 s after a loss.

    address: "192.168.7.1:50443", or "unix:/path/driftwised.sock". ca: PEM file of the authority that signed the daemon's
    certificate; without it the connection is plain, which only loopback takes. cert, key: PEM files of a client
    certificate. token, token_file: a token, or the file that holds it, read again for each call.
    name: stands in the record where nobody proves anything.
    """

    def __init__(self, address: str, *, ca: Optional[str] = None, cert: Optional[str] = None, key: Optional[str] = None,
                 token: Optional[str] = None, token_file: Optional[str] = None, name: str = "python") -> None:
        if (cert is None) != (key is None):
            raise ValueError("cert and key belong together: give both or none")
        if cert is not None and ca is None:
            raise ValueError("a client certificate is shown over TLS only: give ca, the authority of the daemon")
        if token is not None and token_file is not None:
            raise ValueError("give token or token_file, not both")
        self.address = address
        self._name = name
        self._token = None if token is None else _token_in(token, "token")
        self._token_file = token_file
        options = [("grpc.enable_http_proxy", 0), ("grpc.max_reconnect_backoff_ms", 1000),
                   ("grpc.initial_reconnect_backoff_ms", 200), ("grpc.keepalive_time_ms", 60_000)]
        if ca is None:
            self._channel = grpc.insecure_channel(address, options)
        else:
            credentials = grpc.ssl_channel_credentials(_read(ca), _read(key), _read(cert))
            self._channel = grpc.secure_channel(address, credentials, options)
        self._lost = threading.Lock()
        self._returning = False  # under _lost
        self._pollers: List[threading.Thread] = []  # of the way back

    def __enter__(self) -> "Cell":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        atexit.unregister(self._give_up_returning)
        self._channel.close()

    def target(self, pose: Optional[Dict[str, float]] = None, timeout_s: float = 1.0, **coordinates: float) -> Target:
        """Motor coordinates of a pose under the present conditions: target(x_mm=1.5, force_N=0). Everything that the
        serving model needs is stated, 0 included."""
        request = _CLASS["ComputeTargetRequest"](pose=self._pose(pose, coordinates))
        return _target_from(self._ask("TargetService/ComputeTarget", request, "ComputeTargetResponse", timeout_s).target)

    def targets(self, pose: Optional[Dict[str, float]] = None, min_interval_s: float = 0.0,
                **coordinates: float) -> Iterator[Target]:
        """The same again whenever the conditions change. Ends with a DriftwiseError when the daemon is lost; Follower
        connects again by itself."""
        call = self._watch(self._pose(pose, coordinates), min_interval_s)
        try:
            for answer in call:
                yield _target_from(answer.target)
        except grpc.RpcError as failed:
            raise self._error_of(failed) from None
        finally:
            call.cancel()

    def follow(self, pose: Optional[Dict[str, float]] = None, min_interval_s: float = 0.0,
               on_change: Optional[Callable[["Follower"], None]] = None, **coordinates: float) -> "Follower":
        return Follower(self, self._pose(pose, coordinates), min_interval_s, on_change)

    def stop_all(self, timeout_s: float = 2.0) -> Stopped:
        """Halts every axis; a run under way is paused. A stop by software: not confirmed means the emergency switch."""
        try:
            answer = self._ask("CellService/StopAll", _CLASS["StopAllRequest"](), "StopAllResponse", timeout_s)
        except DriftwiseError as failed:  # whatever the reason: who asked for a stop must know that none was made
            raise DriftwiseError(failed.reason, f"NOT STOPPED: use the emergency switch: {failed}", failed.code) from failed
        return Stopped(answer.confirmed, answer.message)

    def who_am_i(self, timeout_s: float = 2.0) -> Identity:
        answer = self._ask("AccessService/GetIdentity", _CLASS["GetIdentityRequest"](), "GetIdentityResponse", timeout_s)
        who = answer.identity
        return Identity(who.name, _ROLES.get(who.role, "unknown"), who.proof)

    @staticmethod
    def _pose(pose: Optional[Dict[str, float]], coordinates: Dict[str, float]) -> List[object]:
        stated = {**(pose or {}), **coordinates}
        return [_CLASS["ChannelValue"](channel=channel, value=float(value)) for channel, value in stated.items()]

    def _metadata(self) -> List[Tuple[str, object]]:
        ascii_name = self._name.isascii() and self._name.isprintable()
        out: List[Tuple[str, object]] = [("driftwise-operator", self._name) if ascii_name else
                                         ("driftwise-operator-bin", self._name.encode())]
        token = self._token if self._token_file is None else self._token_of_file()
        if token:
            out.append(("authorization", "Bearer " + token))
        return out

    def _token_of_file(self) -> str:
        try:
            return _token_in((_read(self._token_file) or b"").decode("ascii", "replace"), self._token_file or "")
        except OSError as failed:
            raise DriftwiseError("NO_TOKEN", str(failed)) from failed
        except ValueError as failed:
            raise DriftwiseError("BAD_CREDENTIALS", str(failed)) from failed

    def _ask(self, method: str, request: object, answer: str, timeout_s: float):
        call = self._channel.unary_unary("/driftwise.v1." + method, type(request).SerializeToString,
                                         _CLASS[answer].FromString)
        try:
            return call(request, timeout=timeout_s, metadata=self._metadata())
        except grpc.RpcError as failed:
            raise self._error_of(failed) from None

    def _error_of(self, failed: grpc.RpcError) -> DriftwiseError:
        error = _error_of(failed, self.address)
        # Way back to a lost daemon. gRPC moves an attempt to connect forward only while somebody waits for it; calls that
        # fail at once leave it to a poller that comes every 5 s. A subscription waits in their place until it is there.
        if error.reason == "NO_DAEMON":
            with self._lost:
                begins, self._returning = not self._returning, True
            if begins:
                others = set(threading.enumerate())
                atexit.register(self._give_up_returning)
                self._channel.subscribe(self._on_connectivity, try_to_connect=True)
                self._pollers = [one for one in threading.enumerate() if one not in others]
        return error

    def _give_up_returning(self) -> None:
        """A program that ends without close(): gRPC's poller, which runs on into the end of the interpreter, would print
        a traceback there. It ends by itself, within 0.2 s, once nobody subscribes."""
        self._channel.unsubscribe(self._on_connectivity)
        for one in self._pollers:
            one.join(2)

    def _on_connectivity(self, state: grpc.ChannelConnectivity) -> None:
        if state is grpc.ChannelConnectivity.READY:
            self._channel.unsubscribe(self._on_connectivity)
            atexit.unregister(self._give_up_returning)
            with self._lost:
                self._returning = False

    def _watch(self, pose: List[object], min_interval_s: float):
        interval = duration_pb2.Duration()
        interval.FromMicroseconds(int(1e6 * min_interval_s))
        request = _CLASS["WatchTargetsRequest"](pose=pose, min_interval_duration=interval)
        call = self._channel.unary_stream("/driftwise.v1.TargetService/WatchTargets", type(request).SerializeToString,
                                          _CLASS["WatchTargetsResponse"].FromString)
        return call(request, metadata=self._metadata())


class Follower:
    """The newest target of one pose, kept by a thread. latest() answers from memory and never waits for the network; when
    the daemon is lost it raises NO_DAEMON instead of an old target, and connects again by itself within about 2 s. When the
    daemon or the network falls silent it raises EXPIRED as soon as the target has lived from conditions_time to valid_until.
    An interval longer than a target lives becomes half of that: else none would be good for most of the time."""

    def __init__(self, cell: Cell, pose: List[object], min_interval_s: float,
                 on_change: Optional[Callable[["Follower"], None]]) -> None:
        self._cell, self._pose, self._interval_s, self._on_change = cell, pose, min_interval_s, on_change
        self._changed = threading.Condition()
        self._target: Optional[Target] = None
        self._expires = 0.0  # by time.monotonic(): the daemon's clock need not agree with this computer's
        self._error = DriftwiseError("NOT_YET", "nothing was heard from the daemon yet")
        self._sequence = 0
        self._again = False  # of the thread: the stream is asked for anew, with a shorter interval
        self._ending = threading.Event()
        self._call = None
        self._thread = threading.Thread(target=self._run, name="driftwise-follower", daemon=True)
        self._thread.start()

    def latest(self) -> Target:
        with self._changed:
            if self._target is None:
                raise DriftwiseError(self._error.reason, str(self._error), self._error.code)
            if time.monotonic() > self._expires:
                raise DriftwiseError("EXPIRED", f"the newest target is past its valid_until, and {self._cell.address} has "
                                     "sent no other: the daemon or the network is silent")
            return self._target

    @property
    def sequence(self) -> int:
        """Grows with every change of latest()."""
        with self._changed:
            return self._sequence

    def wait(self, seen: int, timeout_s: float) -> int:
        """Returns when sequence differs from seen, or at the time limit; the sequence then."""
        with self._changed:
            self._changed.wait_for(lambda: self._sequence != seen, timeout_s)
            return self._sequence

    def close(self) -> None:
        self._ending.set()
        if self._call is not None:
            self._call.cancel()
        self._thread.join(5)

    def _put(self, target: Optional[Target], error: Optional[DriftwiseError]) -> None:
        with self._changed:
            self._target = target
            if target is not None:
                # One that is expired when it comes says so by a flag.
                lifetime_s = (target.valid_until - target.conditions_time).total_seconds()
                lifetime_s = lifetime_s if lifetime_s > 0 else 10.0
                self._expires = time.monotonic() + lifetime_s
                if lifetime_s < self._interval_s:  # else there would be no target for most of the time
                    self._interval_s = lifetime_s / 2
                    self._again = True
            if error is not None:
                self._error = error
            self._sequence += 1
            self._changed.notify_all()
        if self._on_change is not None:
            try:
                self._on_change(self)
            except Exception:  # the caller's: it is said, and the following goes on
                traceback.print_exc()

    def _run(self) -> None:
        while not self._ending.is_set():
            error: Optional[DriftwiseError] = None
            try:
                self._call = self._cell._watch(self._pose, self._interval_s)
                for answer in self._call:
                    self._put(_target_from(answer.target), None)
                    if self._again:
                        self._call.cancel()
                        break
            except grpc.RpcError as failed:
                error = self._cell._error_of(failed)
            except DriftwiseError as failed:  # the token's file
                error = failed
            except Exception as failed:  # a thread that died would leave latest() as it is for ever
                error = DriftwiseError("CLIENT_FAILED", f"{type(failed).__name__}: {failed}")
            if self._ending.is_set():
                return
            if self._again:
                self._again = False
                continue
            self._put(None, error or DriftwiseError("NO_DAEMON", f"the daemon at {self._cell.address} has ended"))
            self._ending.wait(0.5 + 0.5 * random.random())


def _main() -> int:
    parser = argparse.ArgumentParser(description="One compensated target as JSON.")
    for flag in ("--ca", "--cert", "--key", "--token-file"):
        parser.add_argument(flag)
    parser.add_argument("--timeout", type=float, default=10.0, help="seconds")
    parser.add_argument("address", help="host:port of the daemon")
    parser.add_argument("pose", nargs="+", help="x_mm=1.5")
    given = parser.parse_args()
    try:
        pose = {name: float(value) for name, _, value in (one.partition("=") for one in given.pose)}
        cell = Cell(given.address, ca=given.ca, cert=given.cert, key=given.key, token_file=given.token_file)
    except (ValueError, OSError) as wrong:
        parser.error(str(wrong))
    with cell:
        try:
            target = cell.target(pose, timeout_s=given.timeout)
        except DriftwiseError as refused:
            print(f"{refused.reason}: {refused}", file=sys.stderr)
            return 4 if refused.reason in ("NO_DAEMON", "TIMEOUT") else 5
    answer = {**target.q_mm, "u90_nm": {one.channel: one.u90_nm for one in target.coordinates},
              "valid_until": target.valid_until.isoformat(), "model_id": target.model_id, "flags": list(target.flags)}
    print(json.dumps(answer))
    return 0


if __name__ == "__main__":
    sys.exit(_main())
