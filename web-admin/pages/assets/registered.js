// Asks the learning platform to close the window or frame of a registration (LTI Dynamic Registration 1.0, section 3.8). The platform's page is
// the one that has opened this window, or the one around its frame; the message contains nothing to be kept from others.

(window.opener ?? window).parent.postMessage({ subject: "org.imsglobal.lti.close" }, "*");
