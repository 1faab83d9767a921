// One client per service, over gRPC-Web to where the page came from. Every call carries the operator's name, as the
// command line sends it: plain when it is printable ASCII, in the -bin form otherwise (server/rpc/shared/caller.cc), and the
// daemon's time that the page heard last: what moves is refused when that is long ago (server/rpc/shared/heard.h).
import { effect } from '@preact/signals';
import { Code, ConnectError, createClient, type Interceptor, type Transport } from '@connectrpc/connect';
import { createGrpcWebTransport } from '@connectrpc/connect-web';
import type { DescService } from '@bufbuild/protobuf';
import { CellService } from './gen/driftwise/v1/cell_service_pb';
import { DiagnosisService } from './gen/driftwise/v1/diagnosis_service_pb';
import { RunService } from './gen/driftwise/v1/run_service_pb';
import { WatchService } from './gen/driftwise/v1/watch_service_pb';
import { operatorName, sessionLost } from '@/app/session';
import { connection } from '@/live/connection';

const base64 = (text: string) => btoa(String.fromCharCode(...new TextEncoder().encode(text))).replace(/=+$/, '');
const printable = /^[\x20-\x7e]+$/;

export function operatorHeader(name: string): [string, string] | undefined {
  if (name === '') return undefined;
  if (printable.test(name)) return ['driftwise-operator', name];
  return ['driftwise-operator-bin', base64(name)];
}

let heardMs: number | undefined;

export function heard(serverMs: number | undefined): void {
  heardMs = serverMs ?? heardMs;
}

const whoAsks: Interceptor = (next) => (request) => {
  const header = operatorHeader(operatorName.value);
  if (header) request.header.set(...header);
  if (heardMs !== undefined) request.header.set('driftwise-heard-ms', String(Math.floor(heardMs)));
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

// A call under way when the page is no longer live may hang on a connection that died: it fails, so that a question is asked
// again and a command says that it was not answered. Stop is judged by its presses alone (app/stop.tsx).
const underWay = new Set<(why: ConnectError) => void>();

effect(() => {
  if (connection.value.phase !== 'lost') return;
  for (const fail of underWay) fail(new ConnectError('the page is no longer live', Code.Unavailable));
});

const endsWithTheLine: Interceptor = (next) => async (request) => {
  if (request.stream || request.method === CellService.method.stopAll) return next(request);
  let fail = (_: ConnectError): void => undefined;
  const lost = new Promise<never>((_, failed) => (fail = failed));
  underWay.add(fail);
  try {
    return await Promise.race([next(request), lost]);
  } finally {
    underWay.delete(fail);
  }
};

// Stop goes by a WebSocket: never behind the six connections of the other calls and tabs, nor down one that died
// (server/web/stop_socket.h). Where none opens, as behind a proxy that knows no WebSocket, by an ordinary call too.
const opensWithinMs = 1000;

export const stopFetch: typeof fetch = (input, init) =>
  new Promise((done, failed) => {
    const socket = new WebSocket(`${String(input).replace(/^http/, 'ws')}?operator=${base64(operatorName.value).replace(/\+/g, '-').replace(/\//g, '_')}`);
    let open = true;
    const otherwise = () => {
      clearTimeout(timer);
      if (open) fetch(input, init).then(done, failed);
      open = false;
    };
    const timer = setTimeout(otherwise, opensWithinMs);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => clearTimeout(timer);
    socket.onclose = otherwise;
    socket.onmessage = ({ data }) => {
      open = false;
      clearTimeout(timer);
      done(new Response(data as ArrayBuffer, { headers: { 'content-type': 'application/grpc-web+proto' } }));
    };
    init?.signal?.addEventListener('abort', () => {
      open = false;
      clearTimeout(timer);
      socket.close();
      failed(init.signal!.reason);
    });
  });

const pageFetch: typeof fetch = (input, init) => (String(input).endsWith('/StopAll') ? stopFetch : fetch)(input, init);

let transport: Transport | undefined;

// Tests put a transport in memory here, before the first call.
export function useTransport(other: Transport): void {
  transport = other;
}

function pageTransport(): Transport {
  transport ??= createGrpcWebTransport({ baseUrl: location.origin, fetch: pageFetch, interceptors: [whoAsks, whoIsOut, endsWithTheLine] });
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
