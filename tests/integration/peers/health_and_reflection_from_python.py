#!/usr/bin/python3
"""Health and reflection of a gRPC server, asked with bytes made by hand: no proto file at all.

Usage: health_and_reflection_from_python.py host:port
Prints {"health": "SERVING", "health_of_run_service": "SERVING", "services": ["driftwise.v1.RunService", ...]}.
Exit code 77: python3-grpcio is not installed (a skipped test).
"""
import json
import re
import sys

STATES = {b"\x08\x01": "SERVING", b"\x08\x02": "NOT_SERVING"}  # HealthCheckResponse.status, field 1
LIST_SERVICES = b"\x3a\x00"  # ServerReflectionRequest.list_services, field 7, empty text


def main():
    try:
        import grpc
    except ImportError as missing:
        print("skipped:", missing, file=sys.stderr)
        return 77
    with grpc.insecure_channel(sys.argv[1]) as channel:
        check = channel.unary_unary("/grpc.health.v1.Health/Check")

        def health(service):
            name = service.encode()
            request = b"\x0a" + bytes([len(name)]) + name if name else b""
            return STATES.get(check(request, timeout=20), "?")

        reflect = channel.stream_stream("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo")
        answer = next(iter(reflect(iter([LIST_SERVICES]), timeout=20)))
        services = [name.decode() for name in re.findall(rb"[a-z]+[.][A-Za-z0-9.]+", answer)]
        print(json.dumps({"health": health(""), "health_of_run_service": health("driftwise.v1.RunService"),
                          "services": services}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
