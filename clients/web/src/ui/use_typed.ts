// Text that a person types, kept over reloads and lost connections until it was taken: the third element empties the field then, so that
// nothing goes into the next answer unseen.
import { useCallback, useState } from 'preact/hooks';
import { typed } from '@/app/storage';

export function useTyped(key: string, initial = ''): [string, (text: string) => void, () => void] {
  const [text, setText] = useState(() => typed.get(key) ?? initial);
  const change = useCallback((next: string) => {
    setText(next);
    typed.set(key, next);
  }, [key]);
  const taken = useCallback(() => {
    setText(initial);
    typed.set(key, '');
  }, [key]);
  return [text, change, taken];
}
