// Asks again every few seconds while something is under way: what the stream says comes sooner, this makes sure of the end. A question
// that is still under way is not asked again: on a slow line no answer would ever arrive.
import { useEffect, useRef } from 'preact/hooks';
import type { Asked } from './use_asked';

export function useWhile(underWay: boolean, { again, waiting }: Pick<Asked<unknown>, 'again' | 'waiting'>, everyMs = 2000): void {
  const onItsWay = useRef(waiting);
  onItsWay.current = waiting;
  useEffect(() => {
    if (!underWay) return;
    const timer = setInterval(() => !document.hidden && !onItsWay.current && again(), everyMs);
    return () => clearInterval(timer);
  }, [underWay, again, everyMs]);
}
