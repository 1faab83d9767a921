// Trajectories: bring one, see what a run of it would do, keep it, start it.
import { segments } from '@/app/router';
import { Empty } from '@/ui/states';
import { ViewTitle } from '@/ui/view_title';
import { TrajectoryList } from './list';
import { TrajectoryPage } from './page';
import './view.css';

export default function Trajectories() {
  const [, which] = segments.value;
  if (which === undefined) return <TrajectoryList />;
  if (/^\d+$/.test(which)) return <TrajectoryPage id={BigInt(which)} key={which} />;
  return (
    <>
      <ViewTitle>Trajectories</ViewTitle>
      <Empty next={<a href="/trajectories">All trajectories</a>}>There is no trajectory "{which}": trajectories have numbers.</Empty>
    </>
  );
}
