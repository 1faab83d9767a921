import { ViewTitle } from '@/ui/view_title';

export default function Runs() {
  return <ViewTitle>Runs</ViewTitle>;
}
