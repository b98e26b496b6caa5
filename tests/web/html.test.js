import assert from "node:assert";
import { readdirSync, readFileSync } from "node:fs";
import test from "node:test";
import { Html, html, put } from "../../app/web/shared/text.js";

test("a value in markup is escaped, and markup in markup is not", () => {
  const name = `<img onerror="x">'`;
  const rows = [name, "b & c"].map((one) => html`<li>${one}</li>`);
  assert.equal(
    String(html`<ul title="${name}">${rows}</ul>`),
    '<ul title="&lt;img onerror=&quot;x&quot;&gt;&#39;">' +
      "<li>&lt;img onerror=&quot;x&quot;&gt;&#39;</li><li>b &amp; c</li></ul>",
  );
});

test("a line break in a template is a space between words or in a tag, and nothing beside a tag or a value", () => {
  const value = "a\n b"; // one in a value stays
  const made = html`<p class="x"
    title="two
      words">${value}
    <b>three
      words</b>
  </p>`;
  assert.equal(String(made), '<p class="x" title="two words">a\n b<b>three words</b></p>');
});

test("what is absent is left out, and zero is not", () => {
  assert.equal(String(html`${null}${undefined}${false}${""}${0}${[]}`), "0");
});

test("only markup that html made is written into the page", () => {
  const box = { innerHTML: "" };
  put(box, html`<b>${1}</b>`);
  assert.equal(box.innerHTML, "<b>1</b>");
  assert.throws(() => put(box, "<b>1</b>"), /every value is escaped/);
  assert.ok(html`x` instanceof Html);
});

test("markup is made and written in one place, and a value in a tag stands in quotes", () => {
  const web = new URL("../../app/web/", import.meta.url);
  const names = readdirSync(web, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".js"));
  const scripts = names.map((name) => [name, readFileSync(new URL(name, web), "utf8")]);
  const having = (pattern) => scripts.flatMap(([name, text]) => (pattern.test(text) ? [name] : []));
  assert.deepEqual(having(/innerHTML|outerHTML|insertAdjacentHTML|new Html/), ["shared/text.js"]);
  assert.deepEqual(having(/<[a-z][^<>`]*[\w-]=\$\{/), []);
});
