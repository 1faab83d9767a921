import { render } from 'preact';
import '@/styles/tokens.css';
import '@/styles/base.css';
import '@/styles/ui.css';
import '@/styles/print.css';
import { followPrinting } from '@/app/printing';
import { followTheme } from '@/app/theme';
import { readReport } from './data';
import { ReportPage } from './page';

const root = document.getElementById('app')!;
followTheme();
followPrinting();
try {
  const report = readReport(document.getElementById('report-data')?.textContent ?? 'null');
  document.title = `Run ${report.run.id} – Driftwise`;
  render(<ReportPage report={report} />, root);
} catch (error) {
  render(<main><h1>No report</h1><p role="alert">{(error as Error).message}</p></main>, root);
}
