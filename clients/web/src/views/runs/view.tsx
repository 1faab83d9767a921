// Runs: the list, or one of them with its points, plots, dataset and log.
import './view.css';
import { segments } from '@/app/router';
import { Empty } from '@/ui/states';
import { ViewTitle } from '@/ui/view_title';
import { RunList } from './list';
import { RunPage } from './page';

export default function Runs() {
  const [, which] = segments.value;
  if (which === undefined) return <RunList />;
  if (/^\d+$/.test(which)) return <RunPage id={BigInt(which)} key={which} />;
  return (
    <>
      <ViewTitle>Runs</ViewTitle>
      <Empty next={<a href="/runs">All runs</a>}>There is no run "{which}": runs have numbers.</Empty>
    </>
  );
}
