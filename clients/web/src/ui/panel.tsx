import type { ComponentChildren, RefCallback } from 'preact';
import { useId } from 'preact/hooks';

// A framed part of a view. With a title it is a region that screen readers can jump to.
export function Panel({ title, actions, class: name = '', root, children }: {
  title?: ComponentChildren;
  actions?: ComponentChildren;
  class?: string;
  root?: RefCallback<HTMLElement>;
  children: ComponentChildren;
}) {
  const id = useId();
  return (
    <section ref={root} class={`panel ${name}`} aria-labelledby={title ? id : undefined}>
      {(title || actions) && (
        <div class="panel-head">
          {title && <h2 id={id}>{title}</h2>}
          {actions && <div class="actions">{actions}</div>}
        </div>
      )}
      {children}
    </section>
  );
}
