# Manual pages, one a command (help2man), and the completion of three shells, all from the program's own option tree.
find_program(TRUNNION_HELP2MAN help2man)
mark_as_advanced(TRUNNION_HELP2MAN)

set(share ${PROJECT_BINARY_DIR}/share)
set(made ${share}/completion.bash ${share}/completion.zsh ${share}/completion.fish)
add_custom_command(OUTPUT ${made}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${share}
  COMMAND trunnion completion bash > ${share}/completion.bash
  COMMAND trunnion completion zsh > ${share}/completion.zsh
  COMMAND trunnion completion fish > ${share}/completion.fish
  DEPENDS trunnion VERBATIM)
install(FILES ${share}/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME trunnion
  COMPONENT runtime OPTIONAL)
install(FILES ${share}/completion.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _trunnion
  COMPONENT runtime OPTIONAL)
install(FILES ${share}/completion.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d RENAME trunnion.fish
  COMPONENT runtime OPTIONAL)

if(TRUNNION_HELP2MAN)
  set(page ${share}/trunnion.1)
  add_custom_command(OUTPUT ${page}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${share}
    COMMAND ${TRUNNION_HELP2MAN} --no-info --section=1 --name "rotary-axis errors of five-axis machines" --output=${page}
      $<TARGET_FILE:trunnion>
    DEPENDS trunnion VERBATIM)
  list(APPEND made ${page})
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime OPTIONAL)
  foreach(command doctor identify close plan import "import probe-log" evaluate tables correct predict report history
      "history add" "history list" "history show" "history compare" "history trend" "history drift" "history prior" batch
      completion)
    string(REPLACE " " "-" page ${command})
    set(page ${share}/trunnion-${page}.1)
    add_custom_command(OUTPUT ${page}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${share}
      COMMAND ${TRUNNION_HELP2MAN} --no-info --section=1 --name "the command ${command} of trunnion"
        --version-string=${PROJECT_VERSION} --output=${page} "$<TARGET_FILE:trunnion> ${command}"
      DEPENDS trunnion VERBATIM)
    list(APPEND made ${page})
    install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime OPTIONAL)
  endforeach()
endif()
add_custom_target(manual ALL DEPENDS ${made})
