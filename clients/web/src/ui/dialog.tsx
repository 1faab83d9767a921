// A question or page above everything else. It makes the rest of the page inert, the bar with it; so each brings a Stop of its
// own, in the place of the bar's, and the words of the live region.
import type { ComponentChildren } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { LiveRegion } from '@/app/live_region';
import { StopButton } from '@/app/stop';

export function Dialog({ subject, onEnd, titleId, label, class: looks, lightly, children }: {
  subject: unknown; // falsy: closed; another one is another question, with the focus at its beginning
  onEnd: () => void; // Esc, or the browser's own way back
  titleId?: string;
  label?: string; // without a title
  class?: string;
  lightly?: boolean; // a press beside it ends it
  children: ComponentChildren;
}) {
  const box = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const dialog = box.current!;
    if (!subject) return dialog.close();
    if (!dialog.open) dialog.showModal();
    dialog.querySelector<HTMLButtonElement>('[data-harmless] button')?.focus();
  }, [subject]);
  return (
    <dialog
      ref={box}
      class={looks}
      aria-labelledby={titleId}
      aria-label={label}
      onCancel={(event) => { event.preventDefault(); onEnd(); }}
      onClose={() => subject && !box.current?.open && onEnd() /* a browser closes on a second Esc without asking */}
      onClick={(event) => lightly && event.target === box.current && onEnd()}
    >
      {Boolean(subject) && <>{children}<StopButton /><LiveRegion /></>}
    </dialog>
  );
}
