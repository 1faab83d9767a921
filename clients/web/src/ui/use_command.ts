// One command of a component: asks for the operator's name the first time, sends it, knows whether it is under way, keeps what failed until the next try.
import { useCallback, useState } from 'preact/hooks';
import { named } from '@/app/name';
import { failureOf, type Failure } from '@/api/errors';

export interface Command<A extends unknown[]> {
  send: (...args: A) => Promise<boolean>; // true: the daemon took it
  busy: boolean;
  failure: Failure | undefined;
  forget: () => void;
}

export function useCommand<A extends unknown[]>(act: (...args: A) => Promise<unknown>, changes: 'changes' | 'reads' = 'changes'): Command<A> {
  const [state, setState] = useState<{ busy: boolean; failure?: Failure }>({ busy: false });
  const send = async (...args: A): Promise<boolean> => {
    if (state.busy || (changes === 'changes' && !(await named()))) return false;
    setState({ busy: true });
    try {
      await act(...args);
      setState({ busy: false });
      return true;
    } catch (error) {
      setState({ busy: false, failure: failureOf(error) });
      return false;
    }
  };
  const forget = useCallback(() => setState({ busy: false }), []);
  return { send, busy: state.busy, failure: state.failure, forget };
}
