import { ViewTitle } from '@/ui/view_title';

export default function Targets() {
  return <ViewTitle>Targets</ViewTitle>;
}
