// The four states a part of a page can be in besides having its data: awaited, empty, failed, partial.
import type { ComponentChildren } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import type { Failure } from '@/api/errors';
import { Button } from './button';
import { Mark } from './verdict';

// Says what is awaited, but only after 300 ms: faster answers do not flicker.
export function Awaiting({ what }: { what: string }) {
  const [late, setLate] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => setLate(true), 300);
    return () => clearTimeout(timer);
  }, []);
  return <p class="muted awaiting">{late ? `Waiting for ${what} …` : '\u00a0'}</p>;
}

// Why there is nothing, and the next step.
export function Empty({ children, next }: { children: ComponentChildren; next?: ComponentChildren }) {
  return (
    <div class="empty">
      <p>{children}</p>
      {next && <p>{next}</p>}
    </div>
  );
}

export function Failed({ asked, failure, again }: { asked: string; failure: Failure; again?: () => void }) {
  return (
    <div class="failed" role="alert">
      <p>
        <Mark kind="bad" /> <strong>{asked}:</strong> {failure.message}
      </p>
      {again && <Button onPress={again} small>Try again</Button>}
    </div>
  );
}

export function Warned({ children }: { children: ComponentChildren }) {
  return (
    <p class="warned">
      <Mark kind="warn" /> <span>{children}</span>
    </p>
  );
}
