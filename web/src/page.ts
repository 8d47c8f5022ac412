/** Elements of the page, and what it says. */

export const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

/** A notice is gone after this many milliseconds; a fault stays until it is closed or mended. */
const NOTICE_TIME = 5000;

let last = 0;

/** Says what is wrong, in one sentence; nothing for an empty one. */
export function complain(text: string) {
  element('message-text').textContent = text;
  element('message').hidden = text === '';
}

/** Says what was done. */
export function tell(text: string) {
  clearTimeout(last);
  const notice = element('notice');
  notice.textContent = text;
  last = window.setTimeout(() => (notice.textContent = ''), NOTICE_TIME);
}

/** Listens for what closes a message. */
export function listenToMessages() {
  element('dismiss').addEventListener('click', () => complain(''));
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') complain('');
  });
}
