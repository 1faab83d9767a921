import { ViewTitle } from '@/ui/view_title';

export default function Record() {
  return <ViewTitle>Record</ViewTitle>;
}
