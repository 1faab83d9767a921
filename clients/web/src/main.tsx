import { render } from 'preact';
import './styles/tokens.css';
import './styles/base.css';
import './styles/shell.css';
import './styles/ui.css';
import { Shell } from './app/shell';
import { followKeys } from './app/keys';
import { followLinks } from './app/router';
import { followTheme } from './app/theme';
import { startStream } from './live/stream';

const root = document.getElementById('app')!;
followTheme();
followLinks(root);
followKeys();
startStream();
render(<Shell />, root);
