// Looking back: runs side by side, channels, remarks at a time.
import { ViewTitle } from '@/ui/view_title';
import { Channels } from './channels';
import { Compare } from './compare';
import { Notes } from './notes';

export default function LookBack() {
  return (
    <>
      <ViewTitle sub="Runs side by side, one channel over time or against another, remarks at an instant">Look back</ViewTitle>
      <div class="stack">
        <Compare />
        <Channels />
        <Notes />
      </div>
    </>
  );
}
