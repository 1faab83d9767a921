// One channel over time: Allan deviation and spectrum; and any channel against any other.
import { useState } from 'preact/hooks';
import { api } from '@/api/client';
import { timestampOf } from '@/format/time';
import { layout } from '@/live/channels';
import { cellTimeMs } from '@/live/state';
import { Plot } from '@/plot/plot';
import type { PlotSpec } from '@/plot/spec';
import { Button } from '@/ui/button';
import { Field, numberTyped } from '@/ui/field';
import { Panel } from '@/ui/panel';
import { Failed } from '@/ui/states';
import { useCommand } from '@/ui/use_command';
import { lookBackApi } from '@/api/look_back';
import { againstPlot, allanPlot, spectrumPlot } from './specs';

function ChannelChoice({ label, value, choose }: { label: string; value: string; choose: (name: string) => void }) {
  return (
    <label class="field">
      <span>{label}</span>
      <select class="input" value={value} onChange={(event) => choose(event.currentTarget.value)}>
        <option value="">none</option>
        {layout.value.map(({ name }) => <option key={name} value={name}>{name}</option>)}
      </select>
    </label>
  );
}

export function Channels() {
  const [name, setName] = useState('');
  const [against, setAgainst] = useState('');
  const [hours, setHours] = useState('1');
  const [shown, setShown] = useState<{ sentence: string; plots: PlotSpec[] }>();
  const wanted = numberTyped(hours);
  const wrong = wanted === undefined || wanted <= 0 || wanted > 1000 ? 'Hours above 0' : undefined;
  const look = useCommand(async () => {
    const to = cellTimeMs.value ?? Date.now();
    const range = { fromTime: timestampOf(to - wanted! * 3600e3), toTime: timestampOf(to) };
    if (against) {
      const { series } = await api.watch().getSeries({ ...range, channels: [against, name], bucketCount: 1000 });
      setShown({ sentence: '', plots: [againstPlot(series[0], series[1])] });
      return;
    }
    const found = await lookBackApi().analyseStability({ ...range, channel: name });
    setShown({ sentence: `${found.sampleCount} values every ${Number(found.intervalS.toPrecision(3))} s: ${found.sentence}`, plots: [allanPlot(found), spectrumPlot(found)] });
  }, 'reads');
  return (
    <Panel title="Channels" actions={<Button busy={look.busy} off={wrong ?? (name === '' ? 'Choose a channel' : name === against ? 'Two different channels' : undefined)} onPress={() => void look.send()}>{against ? 'Plot one against the other' : 'Analyse'}</Button>}>
      <div class="filters">
        <ChannelChoice label="Channel" value={name} choose={setName} />
        <ChannelChoice label="Against (none: Allan deviation and spectrum)" value={against} choose={setAgainst} />
        <Field label="Hours up to now" value={hours} onInput={setHours} wrong={wrong} />
      </div>
      {look.failure && <Failed asked="Read the record" failure={look.failure} />}
      {shown?.sentence && <p>{shown.sentence}</p>}
      {shown?.plots.map((spec) => <Plot key={spec.title} spec={spec} />)}
    </Panel>
  );
}
