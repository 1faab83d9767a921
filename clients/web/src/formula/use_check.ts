// Asks the daemon what a formula offers on some data, a quarter of a second after the last key.
import { useEffect, useState } from 'preact/hooks';
import { modelApi } from '@/api/model';
import { failureOf, wasCancelled, type Failure } from '@/api/errors';
import type { CheckFormulaResponse } from '@/api/gen/driftwise/v1/model_service_pb';

export interface FormulaData {
  runIds: readonly bigint[];
  csv?: Uint8Array; // instead of runs
  excludeSymbols?: readonly string[];
}

export interface FormulaState {
  check?: CheckFormulaResponse; // of the text as it stands, or while waiting of the text before
  of?: string; // which text
  failure?: Failure; // the data are at fault, or the daemon did not answer
  waiting: boolean;
}

const pauseMs = 250;

export function useFormulaCheck(text: string, data: FormulaData | undefined): FormulaState {
  const [state, setState] = useState<FormulaState>({ waiting: false });
  const key = data && `${data.runIds.join(',')}|${data.csv?.length ?? 0}|${data.excludeSymbols?.join(',') ?? ''}`;
  useEffect(() => {
    if (!data || (data.runIds.length === 0 && !data.csv)) {
      setState({ waiting: false });
      return;
    }
    const abort = new AbortController();
    setState((old) => ({ ...old, waiting: true }));
    const timer = setTimeout(async () => {
      try {
        // The daemon refuses an empty formula before it looks at the data; a lone ~ still tells the channels.
        const formula = text.trim() === '' ? '~' : text;
        const fit = { runIds: [...data.runIds], csv: data.csv ?? new Uint8Array(), formula, excludeSymbols: [...(data.excludeSymbols ?? [])] };
        const check = await modelApi().checkFormula({ fit }, { signal: abort.signal });
        if (!abort.signal.aborted) setState({ check, of: text, waiting: false });
      } catch (error) {
        if (abort.signal.aborted || wasCancelled(error)) return;
        setState({ failure: failureOf(error), waiting: false });
      }
    }, pauseMs);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [text, key]);
  return state;
}
