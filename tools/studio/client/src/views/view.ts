// What the application shows between its header and the edge of the window.
export interface View {
  element: HTMLElement;
  /// @returns true where the key was meant for it.
  on_key?(event: KeyboardEvent): boolean;
  dispose(): void;
}
