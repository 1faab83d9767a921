// The one h1 of a view. It takes the focus after a change of view, so that a screen reader says where it is.
import type { ComponentChildren } from 'preact';
import { useEffect } from 'preact/hooks';
import { viewTitle } from '@/app/page_title';

export function ViewTitle({ children, sub, actions, hidden }: {
  children: string;
  sub?: ComponentChildren;
  actions?: ComponentChildren;
  hidden?: boolean; // for screen readers only, where the content says it all
}) {
  useEffect(() => {
    viewTitle.value = children;
  }, [children]);
  return (
    <header class={hidden ? 'sr-only' : 'view-title'}>
      <div>
        <h1 tabIndex={-1} id="view-title">{children}</h1>
        {sub && <p class="muted">{sub}</p>}
      </div>
      {actions && <div class="actions">{actions}</div>}
    </header>
  );
}
