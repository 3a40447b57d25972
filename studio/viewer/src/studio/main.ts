/** Opens the studio. */

import { untranslated } from "../words";
import { Studio } from "./studio";

declare global {
  interface Window {
    /** For scripts in the browser's console, and for tests. */
    phexStudio?: { studio: Studio; untranslated: () => string[] };
  }
}

window.phexStudio = { studio: new Studio(document.getElementById("studio")!), untranslated };
