// Hold to move. By pointer, or by space and enter; released by whatever takes the pointer, the focus or the page away.
import { useEffect, useRef } from 'preact/hooks';
import { commandsOff } from '@/live/commands_off';

export function JogButton({ label, text, off, press, release }: {
  label: string;
  text: string;
  off?: string | undefined; // why it cannot be used now
  press: () => void;
  release: () => void;
}) {
  const down = useRef(false);
  const box = useRef<HTMLButtonElement>(null);
  const why = off ?? commandsOff.value;
  const latest = useRef({ press, release, why });
  latest.current = { press, release, why };
  const begin = () => {
    if (latest.current.why !== undefined || down.current) return;
    down.current = true;
    latest.current.press();
  };
  const up = () => {
    if (!down.current) return;
    down.current = false;
    latest.current.release();
  };
  useEffect(() => {
    const button = box.current!;
    const [page, sheet] = [window, document];
    const pressed = (event: PointerEvent) => {
      if (event.button > 0) return;
      begin();
      button.setPointerCapture?.(event.pointerId);
    };
    const hidden = () => sheet.visibilityState === 'hidden' && up();
    const ends = ['pointerup', 'pointercancel', 'lostpointercapture', 'blur'];
    button.addEventListener('pointerdown', pressed);
    for (const end of ends) button.addEventListener(end, up);
    page.addEventListener('blur', up);
    page.addEventListener('pagehide', up);
    sheet.addEventListener('visibilitychange', hidden);
    return () => {
      button.removeEventListener('pointerdown', pressed);
      for (const end of ends) button.removeEventListener(end, up);
      page.removeEventListener('blur', up);
      page.removeEventListener('pagehide', up);
      sheet.removeEventListener('visibilitychange', hidden);
      up();
    };
  }, []);
  return (
    <button
      ref={box}
      type="button"
      class="button jog"
      aria-label={label}
      aria-disabled={why === undefined ? undefined : 'true'}
      title={why ?? 'Hold to move'}
      onKeyDown={(event) => {
        if (event.key !== ' ' && event.key !== 'Enter') return;
        event.preventDefault();
        if (!event.repeat) begin();
      }}
      onKeyUp={up}
      onContextMenu={(event) => event.preventDefault()}
    >
      {text}
    </button>
  );
}
