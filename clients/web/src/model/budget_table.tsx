// What the uncertainty of a target is made of, per coordinate: one table, a bar per line.
import { BudgetLine_Source, type MotorCoordinate } from '@/api/gen/driftwise/v1/target_service_pb';
import { fixed } from '@/format/numbers';
import { splitChannel } from '@/format/units';
import { Bar } from '@/ui/bar';
import './budget_table.css';

export const sourceWords: Record<BudgetLine_Source, string> = {
  [BudgetLine_Source.UNSPECIFIED]: 'unknown',
  [BudgetLine_Source.FIT]: 'fit: coefficients',
  [BudgetLine_Source.RESIDUAL]: 'residual: what the model does not follow',
  [BudgetLine_Source.TEMPERATURES]: 'temperatures',
  [BudgetLine_Source.SCALE]: 'reading of the scale',
  [BudgetLine_Source.EXTRAPOLATION]: 'outside the fitted domain',
  [BudgetLine_Source.LASER]: 'interferometer at the zero',
  [BudgetLine_Source.DRIFT]: 'slow drift of the interferometer',
  [BudgetLine_Source.BEAM_OFFSET]: 'lever arms × tilts',
  [BudgetLine_Source.TILTS]: 'autocollimators',
  [BudgetLine_Source.BEAM_DIRECTION]: 'beams not square',
  [BudgetLine_Source.MIRROR]: 'flatness of the mirror',
  [BudgetLine_Source.FORCE]: 'force',
};

// A tenth of a nanometre is as fine as anything here is known.
const nm = (value: number | undefined) => fixed(value, value !== undefined && value < 10 ? 1 : 0);

export function BudgetTable({ coordinates }: { coordinates: readonly MotorCoordinate[] }) {
  const sources = [...new Set(coordinates.flatMap((one) => one.budget.map((line) => line.source)))];
  const of = (one: MotorCoordinate, source: BudgetLine_Source) => one.budget.find((line) => line.source === source)?.uNm;
  const most = Math.max(...coordinates.map((one) => one.uNm), 1e-12);
  const size = (source: BudgetLine_Source) => Math.max(...coordinates.map((one) => of(one, source) ?? 0));
  sources.sort((a, b) => size(b) - size(a));
  return (
    <div class="table-scroll budget" tabIndex={0} role="region" aria-label="Uncertainty budget">
      <table>
        <caption class="sr-only">Uncertainty budget: standard uncertainties in nm</caption>
        <thead>
          <tr>
            <th scope="col">standard uncertainty, nm</th>
            <th scope="col"><span class="sr-only">share</span></th>
            {coordinates.map((one) => <th scope="col" class="number" key={one.channel}>{splitChannel(one.channel).symbol}</th>)}
          </tr>
        </thead>
        <tbody>
          {sources.map((source) => (
            <tr key={source}>
              <td>{sourceWords[source]}</td>
              <td class="budget-bar"><Bar share={size(source) / most} /></td>
              {coordinates.map((one) => <td class="number" key={one.channel}>{nm(of(one, source))}</td>)}
            </tr>
          ))}
          <tr class="strong">
            <td>together (root of the sum of squares)</td>
            <td />
            {coordinates.map((one) => <td class="number" key={one.channel}>{nm(one.uNm)}</td>)}
          </tr>
          <tr class="strong">
            <td>U90 = 1.645 × that</td>
            <td />
            {coordinates.map((one) => <td class="number" key={one.channel}>{nm(one.u90Nm)}</td>)}
          </tr>
        </tbody>
      </table>
    </div>
  );
}
