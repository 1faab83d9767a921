// A judgement as shape and word, colour third: a filled circle is good, a diamond extended, a triangle a warning, an
// octagon with a cross bad, an open ring idle.
import type { ComponentChildren } from 'preact';

export type VerdictKind = 'good' | 'extended' | 'warn' | 'bad' | 'idle';

export function Mark({ kind, size = 13 }: { kind: VerdictKind; size?: number }) {
  return (
    <svg class={`mark mark-${kind}`} width={size} height={size} viewBox="0 0 16 16" aria-hidden="true">
      {kind === 'good' && <circle cx="8" cy="8" r="7" fill="currentColor" />}
      {kind === 'extended' && <path d="M8 .5 15.5 8 8 15.5 .5 8Z" fill="currentColor" />}
      {kind === 'warn' && <path d="M8 1 15.5 15H.5Z" fill="currentColor" />}
      {kind === 'bad' && (
        <>
          <path d="M5 .5h6L15.5 5v6L11 15.5H5L.5 11V5Z" fill="currentColor" />
          <path d="m5 5 6 6m0-6-6 6" stroke="var(--panel)" stroke-width="2" />
        </>
      )}
      {kind === 'idle' && <circle cx="8" cy="8" r="6" fill="none" stroke="currentColor" stroke-width="2.5" />}
    </svg>
  );
}

export function Verdict({ kind, children }: { kind: VerdictKind; children: ComponentChildren }) {
  return (
    <span class="verdict">
      <Mark kind={kind} />
      <span>{children}</span>
    </span>
  );
}
