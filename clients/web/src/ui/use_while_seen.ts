// A value that stays as it was while its part of the page is out of sight: what nobody sees is not computed anew. It is the
// latest one again before the part is seen, and on paper.
import type { RefCallback } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { printing } from '@/app/printing';

const ahead = '200px'; // a part this far away is as good as seen

export function useWhileSeen<T>(value: T): [T, RefCallback<HTMLElement>] {
  const [seen, setSeen] = useState(true);
  const [root, setRoot] = useState<HTMLElement | null>(null);
  const kept = useRef(value);
  useEffect(() => {
    if (!root) return undefined;
    const observer = new IntersectionObserver(([entry]) => setSeen(entry.isIntersecting), { rootMargin: ahead });
    observer.observe(root);
    return () => observer.disconnect();
  }, [root]);
  if (seen || printing.value) kept.current = value;
  return [kept.current, setRoot];
}
