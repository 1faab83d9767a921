// Setting a cell up: devices against the cell file, a cell at rest, thermometers, certificates.
import { ViewTitle } from '@/ui/view_title';
import { Certificates } from './certificates';
import { Check } from './check';
import { RestPanel } from './rest';
import { Thermometers } from './thermometers';

export default function Commissioning() {
  return (
    <>
      <ViewTitle sub="Does every device answer as the cell file expects, and is the cell warm?">Commissioning</ViewTitle>
      <div class="stack">
        <Check />
        <RestPanel />
        <Thermometers />
        <Certificates />
      </div>
    </>
  );
}
