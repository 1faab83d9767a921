// A file of the person's own, read in the browser: by choosing it or by dropping it. Says what is wrong before anything is
// sent.
import { useId, useState } from 'preact/hooks';
import { Button } from './button';
import './file_input.css';

export function FileInput({ label, accept, chosen, onFile, onClear, mostBytes }: {
  label: string;
  accept: string;
  chosen?: string | undefined; // name of the file there is
  onFile: (file: { name: string; bytes: Uint8Array }) => void;
  onClear?: () => void;
  mostBytes: number;
}) {
  const id = useId();
  const [over, setOver] = useState(false);
  const [wrong, setWrong] = useState<string>();
  const read = async (file: File | undefined) => {
    if (!file) return;
    if (file.size > mostBytes) {
      setWrong(`${file.name} has ${(file.size / 2 ** 20).toFixed(1)} MiB, at most ${mostBytes >> 20} MiB can be sent`);
      return;
    }
    if (file.size === 0) {
      setWrong(`${file.name} is empty`);
      return;
    }
    setWrong(undefined);
    onFile({ name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) });
  };
  return (
    <div class="field file-input">
      <label for={id}>{label}</label>
      <div
        class={`file-drop${over ? ' file-over' : ''}`}
        onDragOver={(event) => { event.preventDefault(); setOver(true); }}
        onDragLeave={() => setOver(false)}
        onDrop={(event) => { event.preventDefault(); setOver(false); void read(event.dataTransfer?.files[0]); }}
      >
        {/* The browser's own field knows nothing of a dropped file: it would go on saying that none is chosen. */}
        <input
          id={id}
          class="sr-only"
          type="file"
          accept={accept}
          aria-describedby={wrong ? `${id}-says` : undefined}
          onChange={(event) => { void read(event.currentTarget.files?.[0]); event.currentTarget.value = ''; }}
        />
        <label for={id} class="file-choose" aria-hidden="true">{chosen ? 'Choose another…' : 'Choose a file…'}</label>
        <span class={chosen ? 'file-name' : 'note muted'}>{chosen ?? 'or drop it here'}</span>
        {chosen && onClear && <Button small onPress={onClear} label={`Take out ${chosen}`}>Take out</Button>}
      </div>
      {wrong && <span id={`${id}-says`} class="wrong" role="alert">{wrong}</span>}
    </div>
  );
}
