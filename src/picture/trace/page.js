'use strict';
// Steps through a program: reads what `pack.rs` wrote, and shows it. Nothing is loaded.
(async () => {
  const element = id => document.getElementById(id);
  const failed = why => {
    const fault = element('fault');
    fault.textContent = why;
    fault.hidden = false;
  };
  if (!('DecompressionStream' in window)) {
    failed('This browser is too old to unpack the page (it has no DecompressionStream): take one of 2023 or newer.');
    return;
  }

  // What is in the page.
  const packed = Uint8Array.from(atob(element('data').textContent.trim()), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const trace = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const { width, height, every, parts, registers, steps } = trace;
  const pixels = width * height;

  // The versions of each register, by the step that left them.
  const versions = registers.map(() => []);
  let at = 4 + length;
  const bits = () => {
    const plane = new Int32Array(pixels);
    for (let i = 0; i < pixels; i++) plane[i] = bytes[at + (i >> 3)] >> (i & 7) & 1;
    at += (pixels + 7) >> 3;
    return plane;
  };
  const differences = from => {
    const plane = new Int32Array(pixels);
    for (let i = 0; i < pixels; i++) {
      const folded = bytes[at + i] | bytes[at + pixels + i] << 8
        | bytes[at + 2 * pixels + i] << 16 | bytes[at + 3 * pixels + i] << 24;
      const apart = folded >>> 1 ^ -(folded & 1);
      const before = from ? from[i]
        : i === 0 ? 0 : i % width === 0 ? plane[i - width] : plane[i - 1];
      plane[i] = before + apart;
    }
    at += 4 * pixels;
    return plane;
  };
  steps.forEach(([, , , , written], step) => {
    for (const r of written) {
      let twin, chip, quiet;
      if (registers[r][1]) {
        twin = bits();
        chip = bits();
        quiet = trace.quiet ? bits() : chip;
      } else {
        twin = differences(null);
        chip = differences(twin);
        quiet = trace.quiet ? differences(chip) : chip;
      }
      versions[r].push({ step, twin, chip, quiet });
    }
  });
  const version = (r, step) => {
    const all = versions[r];
    let low = 0, high = all.length;
    while (low < high) {
      const middle = low + high >> 1;
      if (all[middle].step <= step) low = middle + 1; else high = middle;
    }
    return all[low - 1];
  };

  // What is looked at.
  let here = 0, pixel = null, playing = 0;
  const noise = element('noise'), apart = element('apart'), limit = element('limit');
  const chip = it => noise.checked ? it.chip : it.quiet;
  const digits = Math.max(1, Math.ceil(Math.log10(parts)));
  const told = (value, isBit) => isBit ? String(value) : (value / parts).toFixed(digits).replace('-', '\u2212');

  // A few pixels that are far off do not move it.
  const median = (a, b) => a.map((v, i) => v - b[i]).sort()[pixels >> 1];

  // One card for each register.
  const make = (name, parent, className) => {
    const made = document.createElement(name);
    if (className) made.className = className;
    parent.append(made);
    return made;
  };
  const cards = registers.map(([name, isBit]) => {
    const card = make('div', element('registers'), 'register');
    const head = make('h3', card);
    make('b', head).textContent = name;
    const use = make('span', head);
    const pair = make('div', card, 'pair');
    const side = what => {
      const figure = make('figure', pair), picture = make('div', figure, 'picture');
      // A column of pixels is no longer than the screen.
      picture.style.maxWidth = `calc(70vh * ${width / height})`;
      const canvas = make('canvas', picture);
      canvas.width = width;
      canvas.height = height;
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', `${name}, ${what}`);
      const mark = make('div', picture, 'mark');
      mark.hidden = true;
      const place = event => {
        const box = canvas.getBoundingClientRect();
        const x = Math.floor((event.clientX - box.left) / box.width * width);
        const y = Math.floor((event.clientY - box.top) / box.height * height);
        if (x >= 0 && x < width && y >= 0 && y < height) look(x, y);
      };
      picture.addEventListener('pointermove', place);
      picture.addEventListener('pointerdown', place);
      return { canvas, mark, image: new ImageData(width, height), caption: make('figcaption', figure) };
    };
    const sides = [side('on the chip'), side('exact')];
    return { name, isBit, card, use, sides, value: make('p', card, 'value'), drawn: [] };
  });

  const gray = (side, plane, isBit, what) => {
    let low = Infinity, high = -Infinity;
    for (const v of plane) {
      if (v < low) low = v;
      if (v > high) high = v;
    }
    const [black, span] = isBit ? [0, 1] : [low, high - low];
    const data = side.image.data;
    for (let i = 0; i < pixels; i++) {
      const level = span > 0 ? 255 * (plane[i] - black) / span : 128;
      data[4 * i] = data[4 * i + 1] = data[4 * i + 2] = level;
      data[4 * i + 3] = 255;
    }
    side.canvas.getContext('2d').putImageData(side.image, 0, 0);
    let set = 0;
    if (isBit) for (const v of plane) set += v;
    side.caption.textContent = `${what} ` + (isBit ? `${set} of ${pixels} are 1` : low === high ? told(low) : `${told(low)} to ${told(high)}`);
  };
  const signed = (side, a, b, isBit) => {
    const middle = isBit ? 0 : median(a, b);
    let most = 0;
    for (let i = 0; i < pixels; i++) most = Math.max(most, Math.abs(a[i] - b[i] - middle));
    const data = side.image.data;
    for (let i = 0; i < pixels; i++) {
      const part = most > 0 ? (a[i] - b[i] - middle) / most : 0;
      const ink = part > 0 ? [0, 114, 178] : [213, 94, 0];
      for (let c = 0; c < 3; c++) data[4 * i + c] = 255 + Math.abs(part) * (ink[c] - 255);
      data[4 * i + 3] = 255;
    }
    side.canvas.getContext('2d').putImageData(side.image, 0, 0);
    side.caption.textContent = isBit ? 'chip \u2212 exact'
      : `chip \u2212 exact \u2212 ${told(middle)}: \u00b1${told(most)}`;
  };

  const lines = [...element('text').children];
  const stops = new Map();
  steps.forEach(([, line], step) => {
    if (!stops.has(line)) stops.set(line, []);
    stops.get(line).push(step);
  });
  lines.forEach((item, i) => {
    const own = stops.get(i + 1);
    if (!own) return;
    item.classList.add('stop');
    // To its next turn, or around to its first.
    item.addEventListener('click', () => go(own.find(step => step > here) ?? own[0]));
  });

  // The words of each frame, for people.
  const count = [];
  steps.forEach(([frame, line], step) => {
    const before = step > 0 && steps[step - 1][0] === frame ? count[step - 1] : -1;
    count.push(line === 0 ? 0 : before + 1);
  });
  const wordsOf = new Map();
  steps.forEach(([frame], step) => wordsOf.set(frame, count[step]));

  const values = () => {
    cards.forEach((card, r) => {
      for (const side of card.sides) side.mark.hidden = !pixel;
      if (!pixel) {
        card.value.textContent = '';
        return;
      }
      const i = pixel.y * width + pixel.x, it = version(r, here);
      const a = chip(it)[i], b = it.twin[i];
      const sign = a >= b ? '+' : '';
      card.value.textContent = `(${pixel.x * every}, ${pixel.y * every}): ${told(a, card.isBit)}, exact ${told(b, card.isBit)}`
        + (a === b ? '' : `, ${sign}${told(a - b, card.isBit)}`);
      for (const { mark } of card.sides) {
        mark.style.left = `${100 * pixel.x / width}%`;
        mark.style.top = `${100 * pixel.y / height}%`;
        mark.style.width = `${100 / width}%`;
        mark.style.height = `${100 / height}%`;
      }
    });
  };
  const column = element('column'), row = element('row');
  const look = (x, y) => {
    pixel = { x, y };
    column.value = x * every;
    row.value = y * every;
    values();
  };
  // The pixel that is shown nearest to the numbers.
  const typed = () => {
    const at = (field, most) => Math.max(0, Math.min(most - 1, Math.round((parseInt(field.value, 10) || 0) / every)));
    pixel = { x: at(column, width), y: at(row, height) };
    values();
  };

  // Below the bar, which stays.
  const reveal = r => {
    const { card } = cards[r];
    card.style.scrollMarginTop = `${element('bar').offsetHeight + 8}px`;
    card.scrollIntoView({ block: 'nearest' });
  };

  const show = () => {
    const [frame, line, text, reads, written] = steps[here];
    const word = element('word');
    word.textContent = line === 0 ? `Frame ${frame}: ` : `Frame ${frame}, word ${count[here]} of ${wordsOf.get(frame)}, line ${line}: `;
    make('code', word).textContent = text;
    element('slide').value = here;
    element('slide').setAttribute('aria-valuetext', word.textContent);
    cards.forEach((card, r) => {
      const it = version(r, here);
      const wrote = line > 0 && written.includes(r), read = reads.includes(r);
      card.card.classList.toggle('written', wrote);
      card.card.classList.toggle('read', read && !wrote);
      card.use.textContent = [read ? 'read' : '', wrote ? 'written' : ''].filter(Boolean).join(', ');
      // Only what has changed is drawn again.
      const now = [it.step, noise.checked, apart.checked];
      if (now.some((part, i) => part !== card.drawn[i])) {
        card.drawn = now;
        const [left, right] = card.sides;
        if (apart.checked) signed(left, chip(it), it.twin, card.isBit);
        else gray(left, chip(it), card.isBit, 'chip');
        gray(right, it.twin, card.isBit, 'exact');
      }
    });
    for (const item of lines) item.classList.remove('here');
    const item = lines[line - 1];
    element('line').firstChild.textContent = item ? item.textContent.trim() : '';
    if (element('follow').checked && line > 0 && written.length > 0) reveal(written[0]);
    if (item) {
      item.classList.add('here');
      const list = element('text');
      if (item.offsetTop < list.scrollTop || item.offsetTop + item.offsetHeight > list.scrollTop + list.clientHeight) {
        list.scrollTop = item.offsetTop - list.clientHeight / 2;
      }
    }
    // A button that is disabled would lose the focus.
    for (const id of ['first', 'back']) element(id).setAttribute('aria-disabled', here === 0);
    for (const id of ['last', 'next']) element(id).setAttribute('aria-disabled', here === steps.length - 1);
    values();
    document.body.dataset.step = here;
  };
  const go = step => {
    here = Math.max(0, Math.min(steps.length - 1, step));
    element('found').textContent = '';
    show();
  };
  const stop = () => {
    clearInterval(playing);
    playing = 0;
    element('play').setAttribute('aria-pressed', 'false');
  };
  const play = () => {
    if (playing) return stop();
    if (here === steps.length - 1) go(0);
    element('play').setAttribute('aria-pressed', 'true');
    playing = setInterval(() => here < steps.length - 1 ? go(here + 1) : stop(), 400);
  };

  // The first step after which a pixel that is shown parts.
  const part = () => {
    const most = Math.max(0, parseFloat(limit.value) || 0) * parts;
    for (let step = 0; step < steps.length; step++) {
      for (const r of steps[step][4]) {
        const it = version(r, step), a = chip(it), b = it.twin;
        const isBit = registers[r][1], middle = isBit ? 0 : median(a, b);
        for (let i = 0; i < pixels; i++) {
          const by = Math.abs(a[i] - b[i] - middle);
          if (isBit ? by > 0 : by > most + 1e-9) {
            go(step);
            look(i % width, Math.floor(i / width));
            element('found').textContent = `${registers[r][0]} parts at (${pixel.x * every}, ${pixel.y * every}): ${told(a[i], isBit)}, exact ${told(b[i], isBit)}`
              + (isBit ? '' : `, median difference ${told(middle)}`);
            reveal(r);
            return;
          }
        }
      }
    }
    element('found').textContent = `No pixel that is shown parts by more than ${limit.value} LSB.`;
  };

  limit.value = trace.limit;
  element('follow').checked = matchMedia('(max-width: 50rem)').matches;
  noise.disabled = !trace.quiet;
  if (!trace.quiet) noise.parentElement.title = 'this arithmetic has no noise';
  for (const [field, most] of [[column, width], [row, height]]) {
    field.max = (most - 1) * every;
    field.step = every;
    field.addEventListener('input', typed);
  }
  element('slide').max = steps.length - 1;
  element('slide').addEventListener('input', event => go(Number(event.target.value)));
  element('first').addEventListener('click', () => go(0));
  element('back').addEventListener('click', () => go(here - 1));
  element('next').addEventListener('click', () => go(here + 1));
  element('last').addEventListener('click', () => go(steps.length - 1));
  element('play').addEventListener('click', play);
  element('part').addEventListener('click', part);
  noise.addEventListener('change', show);
  apart.addEventListener('change', show);
  document.addEventListener('keydown', event => {
    if (event.target.matches('input, button') && !['ArrowLeft', 'ArrowRight'].includes(event.key)) return;
    if (event.target.matches('input[type=range], input[type=number]') || event.ctrlKey || event.metaKey || event.altKey) return;
    const does = {
      ArrowRight: () => go(here + 1), ArrowLeft: () => go(here - 1),
      Home: () => go(0), End: () => go(steps.length - 1), ' ': play,
    }[event.key];
    if (does) {
      event.preventDefault();
      does();
    }
  });
  element('text').tabIndex = 0;
  element('bar').hidden = false;
  document.querySelector('main').hidden = false;
  show();
  document.body.dataset.ready = 'yes';
})();
