#!/usr/bin/python3
"""One target, asked by a program that knows the proto files and nothing else of Driftwise.

Usage: target.py HOST:PORT PROTO_FOLDER x_mm=1.5 [...]
PROTO_FOLDER: "proto" of the sources, or /usr/local/share/driftwise/proto of an installation.
On Debian: apt install python3-grpcio python3-protobuf protobuf-compiler.
Prints one JSON object: {"q1_mm": 1.49988, "u_nm": {"q1_mm": 5.4}, "model_id": 1, "flags": []}.
Exit code 77: python3-grpcio, python3-protobuf or protoc is not installed (a skipped test).
"""
import json
import os
import subprocess
import sys
import tempfile


def generated(proto_folder, output):
    """Python's message classes from the proto files, as anybody would make them."""
    names = ["access", "values", "target_service"]
    files = [os.path.join(proto_folder, "driftwise", "v1", name + ".proto") for name in names]
    subprocess.run(["protoc", "--proto_path", proto_folder, "--python_out", output, *files], check=True)
    sys.path.insert(0, output)
    sys.dont_write_bytecode = True
    from driftwise.v1 import target_service_pb2
    return target_service_pb2


def main():
    address, proto_folder, poses = sys.argv[1], sys.argv[2], sys.argv[3:]
    try:
        import google.protobuf  # noqa: F401
        import grpc
        subprocess.run(["protoc", "--version"], check=True, stdout=subprocess.DEVNULL)
    except (ImportError, OSError) as missing:
        print("skipped:", missing, file=sys.stderr)
        return 77
    with tempfile.TemporaryDirectory() as output:
        messages = generated(proto_folder, output)
        request = messages.ComputeTargetRequest()
        for pose in poses:
            channel_name, _, value = pose.partition("=")
            try:
                request.pose.add(channel=channel_name, value=float(value))
            except ValueError:
                print(f"found {pose}, expected a coordinate and a number with a decimal point, such as x_mm=0.5",
                      file=sys.stderr)
                return 2
        with grpc.insecure_channel(address) as channel:
            # Debian has no grpc_tools: the method by its name, with the generated classes' own serialisers.
            call = channel.unary_unary("/driftwise.v1.TargetService/ComputeTarget",
                                       request_serializer=messages.ComputeTargetRequest.SerializeToString,
                                       response_deserializer=messages.ComputeTargetResponse.FromString)
            try:
                target = call(request, timeout=20, metadata=[("driftwise-operator", "python")]).target
            except grpc.RpcError as error:
                print(f"{error.code().name}: {error.details()}", file=sys.stderr)
                return 5
        answer = {c.channel: c.position_mm for c in target.coordinates}
        answer["u_nm"] = {c.channel: c.u_nm for c in target.coordinates}
        answer["model_id"] = target.model_id
        answer["flags"] = [messages.Target.Flag.Name(flag) for flag in target.flags]
        print(json.dumps(answer))
    return 0


if __name__ == "__main__":
    sys.exit(main())
