// What the simulation gets wrong: the list, one diagnosis, and the loop that mends what was found.
import { segments } from '@/app/router';
import { Empty } from '@/ui/states';
import { ViewTitle } from '@/ui/view_title';
import { ImprovementPage } from './improvement';
import { DiagnosisList } from './list';
import { DiagnosisPage } from './page';
import './view.css';

const isNumber = (text: string | undefined): text is string => text !== undefined && /^\d+$/.test(text);

export default function Diagnosis() {
  const [, which, more] = segments.value;
  if (which === undefined) return <DiagnosisList />;
  if (isNumber(which)) return <DiagnosisPage id={BigInt(which)} key={which} />;
  if (which === 'improve' && isNumber(more)) return <ImprovementPage id={BigInt(more)} key={more} />;
  return (
    <>
      <ViewTitle>Diagnosis</ViewTitle>
      <Empty next={<a href="/diagnosis">All diagnoses</a>}>There is no diagnosis "{which}": diagnoses have numbers.</Empty>
    </>
  );
}
