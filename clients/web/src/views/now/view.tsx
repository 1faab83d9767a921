import { ViewTitle } from '@/ui/view_title';

export default function Now() {
  return <ViewTitle>Now</ViewTitle>;
}
