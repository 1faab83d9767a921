import { ViewTitle } from '@/ui/view_title';

export default function Diagnosis() {
  return <ViewTitle>Diagnosis</ViewTitle>;
}
