import { ViewTitle } from '@/ui/view_title';

export default function Trajectories() {
  return <ViewTitle>Trajectories</ViewTitle>;
}
