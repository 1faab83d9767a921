function line = driftwise_line(host, port, token)
% DRIFTWISE_LINE  Connects to the text line of a daemon; see driftwise_target.
% MATLAB R2021a or later; in Octave the package instrument-control (Debian: octave-instrument-control).
  if exist('OCTAVE_VERSION', 'builtin')
    pkg load instrument-control
    line = tcpclient(char(host), port, 'Timeout', 10);
  else
    line = tcpclient(host, port, "Timeout", 10);
  end
  if nargin > 2
    reply = driftwise_ask(line, ['TOKEN ', char(token)]);
    if ~strncmp(reply, 'OK ', 3)
      words = strsplit(reply, ' ');
      error(['driftwise:', words{2}], '%s', reply);
    end
  end
end
