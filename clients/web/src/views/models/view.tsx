// Models: what was fitted, which of them serves, one in full, two side by side; which method, which thermometers.
import { segments } from '@/app/router';
import { Empty } from '@/ui/states';
import { ViewTitle } from '@/ui/view_title';
import { ComparePage } from './compare';
import { ModelList } from './list';
import { MethodsPage } from './methods';
import { ModelPage } from './page';
import { SensorsPage } from './sensors';
import './view.css';

export default function Models() {
  const [, which] = segments.value;
  if (which === undefined) return <ModelList />;
  if (which === 'compare') return <ComparePage />;
  if (which === 'methods') return <MethodsPage />;
  if (which === 'sensors') return <SensorsPage />;
  if (/^\d+$/.test(which)) return <ModelPage id={BigInt(which)} key={which} />;
  return (
    <>
      <ViewTitle>Models</ViewTitle>
      <Empty next={<a href="/models">All models</a>}>There is no model "{which}": models have numbers.</Empty>
    </>
  );
}
