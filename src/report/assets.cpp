// Files of web/ as bytes of the program.
#define EMBED(name, path)                                                                                        \
  __asm__(".section .rodata\n.global " #name "\n.global " #name "_end\n" #name ":\n.incbin \"" path "\"\n" #name \
          "_end:\n.byte 0\n.previous\n")

EMBED(trunnion_report_css, REPORT_CSS);
EMBED(trunnion_report_js, REPORT_JS);
