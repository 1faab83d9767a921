function reply = driftwise_ask(line, request)
% DRIFTWISE_ASK  One line out, one line back, without its end; see driftwise_target.
  write(line, uint8([char(request), char(10)]));
  bytes = uint8([]);
  while isempty(bytes) || bytes(end) ~= 10
    next = read(line, 1);
    if isempty(next)
      error('driftwise:NO_ANSWER', 'the daemon closed the connection or did not answer in time');
    end
    bytes(end + 1) = uint8(next); %#ok<AGROW>
  end
  reply = char(bytes(1:end - 1));
end
