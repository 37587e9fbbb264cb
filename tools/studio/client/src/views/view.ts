// What the application shows between its header and the edge of the window.
export interface View {
  element: HTMLElement;
  /// @param key  As key_of() names it. @returns true where it was meant for this view.
  on_key?(key: string): boolean;
  dispose(): void;
}
