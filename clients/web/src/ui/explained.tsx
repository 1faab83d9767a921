// A word that not everybody knows, with its meaning one press away: by mouse, keyboard and touch alike.
import type { ComponentChildren } from 'preact';
import { useId } from 'preact/hooks';
import './explained.css';

export function Explained({ word, children }: { word: string; children: ComponentChildren }) {
  const id = useId();
  return (
    <>
      <button type="button" class="explained" popovertarget={id} aria-label={`${word}: what is it?`}>{word}</button>
      <span id={id} popover="auto" class="explained-text note">{children}</span>
    </>
  );
}

export const U90 = () => (
  <Explained word="U90">
    The uncertainty of this target for 90 %: 1.645 times its combined standard uncertainty u, every line of its budget included.
  </Explained>
);

export const S90 = () => (
  <Explained word="S90">
    The scatter of the error: 1.645 times its standard deviation about its mean. The mean is not in it, and is printed with it. The thesis calls it U90.
  </Explained>
);

export const A90 = () => (
  <Explained word="A90">
    The accuracy used throughout: 1.645 times the root mean square of the error, its mean included. Nine of ten errors are smaller, were they normally distributed about zero.
  </Explained>
);
