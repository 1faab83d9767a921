import { ViewTitle } from '@/ui/view_title';

export default function Instruments() {
  return <ViewTitle>Instruments</ViewTitle>;
}
