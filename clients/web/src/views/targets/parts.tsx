// What a correction is made of, per coordinate: bars to both sides of zero on one scale.
import { CorrectionPart_Source, type MotorCoordinate } from '@/api/gen/driftwise/v1/target_service_pb';
import { signed } from '@/format/numbers';
import { splitChannel } from '@/format/units';

const words: readonly [CorrectionPart_Source, string][] = [
  [CorrectionPart_Source.GEOMETRY, 'geometry'],
  [CorrectionPart_Source.FORCE, 'force'],
  [CorrectionPart_Source.TEMPERATURES, 'temperatures'],
];

const partOf = (one: MotorCoordinate, source: CorrectionPart_Source) => one.parts.find((part) => part.source === source)?.nm ?? 0;

export function Parts({ coordinates }: { coordinates: readonly MotorCoordinate[] }) {
  const known = coordinates.filter((one) => one.parts.length > 0);
  if (known.length === 0) return <p class="note muted">The motors of this robot have no wanted coordinate of their own: there is no correction to part.</p>;
  const most = Math.max(...known.flatMap((one) => [Math.abs(one.correctionNm ?? 0), ...one.parts.map((part) => Math.abs(part.nm))]), 1e-9);
  return (
    <div class="table-scroll" tabIndex={0} role="region" aria-label="Parts of the correction">
      <table>
        <caption class="sr-only">Parts of the correction in nm</caption>
        <thead>
          <tr><th scope="col">nm</th>{known.map((one) => <th scope="col" colSpan={2} key={one.channel} class="number">{splitChannel(one.channel).symbol}</th>)}</tr>
        </thead>
        <tbody>
          {words.map(([source, word]) => (
            <tr key={word}>
              <td>{word}</td>
              {known.map((one) => [<td class="parts-bar"><SignedBar share={partOf(one, source) / most} /></td>, <td class="number">{signed(partOf(one, source), 1)}</td>])}
            </tr>
          ))}
          <tr class="strong">
            <td>correction</td>
            {known.map((one) => [<td class="parts-bar"><SignedBar share={(one.correctionNm ?? 0) / most} sum /></td>, <td class="number">{signed(one.correctionNm, 1)}</td>])}
          </tr>
        </tbody>
      </table>
    </div>
  );
}

function SignedBar({ share, sum }: { share: number; sum?: boolean }) {
  const width = Math.min(50, Math.abs(share) * 50);
  return (
    <svg class="bar-svg" viewBox="0 0 100 12" preserveAspectRatio="none" aria-hidden="true">
      <rect class="bar-track" width="100" height="12" />
      <rect class={`bar-fill ${sum ? 'bar-idle' : share < 0 ? 'bar-q1' : 'bar-q2'}`} x={share < 0 ? 50 - width : 50} width={width} height="12" />
      <path class="bar-whisker" d="M50 0V12" vector-effect="non-scaling-stroke" />
    </svg>
  );
}
