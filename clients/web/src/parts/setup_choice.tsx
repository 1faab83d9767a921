// Which of the cell's set-ups measures; nothing where the cell file has none.
import { api } from '@/api/client';
import { useAsked } from '@/ui/use_asked';

export const useSetups = () => useAsked('set-ups', async (signal) => (await api.cell().listDevices({}, { signal })).setupNames);

export function SetupChoice({ names, value, onChoose }: { names: readonly string[] | undefined; value: string; onChoose: (name: string) => void }) {
  if (!names?.length) return null;
  return (
    <label class="field">
      <span>Set-up</span>
      <select class="input" value={value} onChange={(event) => onChoose(event.currentTarget.value)}>
        <option value="">every instrument</option>
        {names.map((name) => <option key={name} value={name}>{name}</option>)}
      </select>
    </label>
  );
}
