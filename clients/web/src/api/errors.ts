// What went wrong, for a person and for a program. The daemon's own sentence already says what was asked, what was found
// and what to do; only losses of the connection get their words here.
import { Code, ConnectError } from '@connectrpc/connect';
import { ErrorDetailSchema } from './gen/driftwise/v1/error_detail_pb';

export interface Failure {
  code: Code;
  reason: string; // "LEASE_HELD", or "" where the daemon gave none
  message: string;
  lost: boolean; // the daemon was not reached: the same call may be tried again
}

export function failureOf(error: unknown): Failure {
  const failed = ConnectError.from(error);
  const detail = failed.findDetails(ErrorDetailSchema)[0];
  if (detail) return { code: failed.code, reason: detail.reason, message: detail.message, lost: false };
  const lost = failed.code === Code.Unavailable || failed.code === Code.Unknown || failed.code === Code.Aborted;
  return {
    code: failed.code,
    reason: '',
    lost,
    message: lost
      ? 'The daemon did not answer. Nothing was changed that is not in the record; try again when the page is live.'
      : failed.rawMessage || wordsFor(failed.code),
  };
}

// Of a refusal without a word.
function wordsFor(code: Code): string {
  if (code === Code.Unimplemented) return 'This daemon does not know that call: page and daemon are of different versions. Reload the page, or update the daemon.';
  return `The daemon refused with ${Code[code]} and gave no reason; its log says more.`;
}

export const wasCancelled = (error: unknown) => ConnectError.from(error).code === Code.Canceled;
