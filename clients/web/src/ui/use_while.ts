// Asks again every few seconds while something is under way: what the stream says comes sooner, this makes sure of the end.
import { useEffect } from 'preact/hooks';

export function useWhile(underWay: boolean, again: () => void, everyMs = 2000): void {
  useEffect(() => {
    if (!underWay) return;
    const timer = setInterval(() => !document.hidden && again(), everyMs);
    return () => clearInterval(timer);
  }, [underWay, again, everyMs]);
}
