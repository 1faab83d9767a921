// One study on the daemon's worker: a stream of progress that ends in the answer. Nothing is stored, so leaving the view, or
// cancelling, ends the work; what was found stays on the page until the next one is started.
import { useEffect, useRef, useState } from 'preact/hooks';
import { failureOf, wasCancelled, type Failure } from '@/api/errors';
import type { StudyProgress } from '@/api/gen/driftwise/v1/model_service_pb';
import { say } from '@/app/live_region';

export interface Study<A> {
  start: () => Promise<void>;
  cancel: () => void;
  busy: boolean;
  progress: StudyProgress | undefined;
  answer: A | undefined;
  of: string; // what the answer is of
  tookMs: number;
  cancelled: boolean;
  failure: Failure | undefined;
}

interface State<A> {
  busy: boolean;
  progress?: StudyProgress;
  answer?: A;
  of?: string;
  tookMs?: number;
  cancelled?: boolean;
  failure?: Failure;
}

// what: "Comparison of methods"; of: "run 1: q ~ x", kept beside the answer.
export function useStudy<A extends { progress?: StudyProgress }>(what: string, of: string, open: (signal: AbortSignal) => AsyncIterable<A>): Study<A> {
  const [state, setState] = useState<State<A>>({ busy: false });
  const abort = useRef<AbortController | undefined>(undefined);
  useEffect(() => () => abort.current?.abort(), []);
  const start = async () => {
    abort.current?.abort();
    const mine = (abort.current = new AbortController());
    const began = performance.now();
    setState((old) => ({ ...old, busy: true, progress: undefined, cancelled: false, failure: undefined }));
    try {
      let answer: A | undefined;
      for await (const message of open(mine.signal)) {
        if (message.progress) setState((old) => ({ ...old, progress: message.progress }));
        else answer = message;
      }
      if (mine.signal.aborted) return;
      setState({ busy: false, answer, of, tookMs: performance.now() - began });
      say(`${what} is done`);
    } catch (error) {
      if (mine.signal.aborted || wasCancelled(error)) return;
      setState((old) => ({ ...old, busy: false, progress: undefined, failure: failureOf(error) }));
    }
  };
  const cancel = () => {
    abort.current?.abort();
    setState((old) => ({ ...old, busy: false, progress: undefined, cancelled: true }));
    say(`${what} is cancelled`);
  };
  return {
    start, cancel, busy: state.busy, progress: state.progress, answer: state.answer, of: state.of ?? '', tookMs: state.tookMs ?? 0,
    cancelled: state.cancelled === true, failure: state.failure,
  };
}
