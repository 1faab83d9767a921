// Which recorded channels stand below each other, in the address: ?ch=t07,force. Without: the temperatures and the force.
import { query, setQuery } from '@/app/router';
import { splitChannel, unitSign } from '@/format/units';
import { Panel } from '@/ui/panel';

const byDefault = (name: string) => /^(t\d+|air.*)_(degC|K)$/.test(name) || name === 'force_N';

export function chosenChannels(all: readonly string[]): string[] {
  const asked = query('ch')?.split(',').filter(Boolean);
  if (!asked) return all.filter(byDefault);
  return all.filter((name) => asked.includes(name) || asked.includes(splitChannel(name).symbol));
}

export function ChannelChoice({ all, chosen }: { all: readonly string[]; chosen: readonly string[] }) {
  const recorded = all.filter((name) => !/_std_nm$|_cmd_mm$/.test(name));
  const turn = (name: string) => {
    const next = chosen.includes(name) ? chosen.filter((one) => one !== name) : [...chosen, name];
    setQuery({ ch: next.map((one) => splitChannel(one).symbol).join(',') || undefined });
  };
  return (
    <Panel>
      <details>
        <summary>Channels shown: {chosen.length} of {recorded.length}</summary>
        <div class="channel-choice">
          {recorded.map((name) => (
            <label key={name} class="choice">
              <input type="checkbox" checked={chosen.includes(name)} onChange={() => turn(name)} />
              {splitChannel(name).symbol} <span class="muted">{unitSign(splitChannel(name).unit)}</span>
            </label>
          ))}
        </div>
      </details>
    </Panel>
  );
}
