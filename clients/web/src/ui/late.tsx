// A part that is fetched after its view stands, so that the view's numbers need not wait for it. Its place is kept free meanwhile.
import type { ComponentType } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { Panel } from './panel';

// height: px of the part inside its panel.
export function late<P extends object>(fetchPart: () => Promise<ComponentType<P>>, height: number): ComponentType<P> {
  let part: ComponentType<P> | undefined;
  return function Late(props: P) {
    const [state, setState] = useState<'waiting' | 'there' | 'failed'>(part ? 'there' : 'waiting');
    useEffect(() => {
      if (part) return undefined;
      let left = false;
      fetchPart().then(
        (fetched) => {
          part = fetched;
          if (!left) setState('there');
        },
        () => !left && setState('failed'),
      );
      return () => void (left = true);
    }, []);
    const Part = part;
    if (Part) return <Part {...props} />;
    return (
      <Panel>
        <div style={{ minHeight: `${height}px` }}>
          {state === 'failed' && <p role="alert">This part could not be fetched: reload the page, nothing typed is lost.</p>}
        </div>
      </Panel>
    );
  };
}
