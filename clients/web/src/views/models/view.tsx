import { ViewTitle } from '@/ui/view_title';

export default function Models() {
  return <ViewTitle>Models</ViewTitle>;
}
