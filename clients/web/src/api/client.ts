// One client per service, over gRPC-Web to where the page came from. Every call carries the operator's name, as the
// command line sends it: plain when it is printable ASCII, in the -bin form otherwise (server/rpc/shared/caller.cc).
import { Code, ConnectError, createClient, type Interceptor, type Transport } from '@connectrpc/connect';
import { createGrpcWebTransport } from '@connectrpc/connect-web';
import type { DescService } from '@bufbuild/protobuf';
import { CellService } from './gen/driftwise/v1/cell_service_pb';
import { DiagnosisService } from './gen/driftwise/v1/diagnosis_service_pb';
import { RunService } from './gen/driftwise/v1/run_service_pb';
import { WatchService } from './gen/driftwise/v1/watch_service_pb';
import { operatorName, sessionLost } from '@/app/session';

const printable = /^[\x20-\x7e]+$/;

export function operatorHeader(name: string): [string, string] | undefined {
  if (name === '') return undefined;
  if (printable.test(name)) return ['driftwise-operator', name];
  const bytes = new TextEncoder().encode(name);
  return ['driftwise-operator-bin', btoa(String.fromCharCode(...bytes)).replace(/=+$/, '')];
}

const whoAsks: Interceptor = (next) => (request) => {
  const header = operatorHeader(operatorName.value);
  if (header) request.header.set(...header);
  return next(request);
};

const whoIsOut: Interceptor = (next) => async (request) => {
  try {
    return await next(request);
  } catch (error) {
    if (ConnectError.from(error).code === Code.Unauthenticated) void sessionLost();
    throw error;
  }
};

let transport: Transport | undefined;

// Tests put a transport in memory here, before the first call.
export function useTransport(other: Transport): void {
  transport = other;
}

function pageTransport(): Transport {
  transport ??= createGrpcWebTransport({ baseUrl: location.origin, interceptors: [whoAsks, whoIsOut] });
  return transport;
}

export function lazily<T extends DescService>(service: T) {
  let client: ReturnType<typeof createClient<T>> | undefined;
  let of: Transport | undefined;
  return () => {
    if (!client || of !== pageTransport()) client = createClient(service, (of = pageTransport()));
    return client;
  };
}

// Calls of the page: api.run().listRuns({ limit: 50 }) and so on; the promise rejects with an error that errors.ts turns
// into words. Services of single views have files of their own beside this one (modelApi), so that the first load does not hold them.
export const api = {
  cell: lazily(CellService),
  diagnosis: lazily(DiagnosisService),
  run: lazily(RunService),
  watch: lazily(WatchService),
};
