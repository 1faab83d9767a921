import { render } from 'preact';
import './styles/tokens.css';
import './styles/base.css';
import './styles/shell.css';
import './styles/ui.css';
import './styles/print.css';
import { Shell } from './app/shell';
import { followPrinting } from './app/printing';
import { followKeys } from './app/keys';
import { followLinks } from './app/router';
import { enter, session } from './app/session';
import { followTheme } from './app/theme';
import { startStream } from './live/stream';

const root = document.getElementById('app')!;
followTheme();
followLinks(root);
followKeys();
followPrinting();
void enter().then(() => {
  if (session.value.state !== 'out') startStream();
  render(<Shell />, root);
});
